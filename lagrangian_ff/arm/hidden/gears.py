"""Properties that every gear of a real arm has some of: presliding, load on its teeth, softness."""

from collections.abc import Collection

import numpy as np

from lagrangian_ff.arm.description import JOINTS
from lagrangian_ff.arm.hidden.base import Installed
from lagrangian_ff.arm.joint_effect import JointEffect, JointMoment
from lagrangian_ff.arm.parameters import ArmParameters
from lagrangian_ff.arm.plant import Gear
from lagrangian_ff.arrays import Floats

TURN = 0.02  # rad/s, over which dry friction on loaded teeth changes its sign
DAMPING = 0.06  # of the critical one


class Presliding(JointEffect):
    """Bristles in all joints at once; see `lagrangian_ff.arm.hidden.solid.Bristles`.

    Args:
        slip: (6,) N·m.
        distance: (6,) rad, over which they bend before they slip.
    """

    def __init__(self, slip: Floats, distance: Floats) -> None:
        self._slip, self._distance = slip, distance
        self._bent = np.zeros(len(JOINTS))

    def reset(self, q: Floats) -> None:
        self._bent = np.zeros(len(JOINTS))

    def _after(self, v: Floats, dt: float) -> tuple[Floats, Floats]:
        """Return the bend relative to `distance` after a step, and its derivative by v."""
        end = np.copysign(1.0, v)
        left = np.exp(np.abs(v) * (-dt / self._distance))
        slope = (1.0 - end * self._bent) * left * (dt / self._distance)
        return end + (self._bent - end) * left, slope

    def torque(self, moment: JointMoment) -> tuple[Floats, Floats]:
        bent, slope = self._after(moment.qd, moment.dt)
        return self._slip * bent, self._slip * slope

    def advance(self, moment: JointMoment) -> None:
        self._bent = self._after(moment.qd, moment.dt)[0]


class LoadedTeeth(JointEffect):
    """Dry friction in all joints at once that is in proportion to the load, a share (6,) of it."""

    def __init__(self, share: Floats) -> None:
        self._share = share

    def torque(self, moment: JointMoment) -> tuple[Floats, Floats]:
        # Below a nanoradian a second there is no motion, and no chord to divide by.
        v = np.where(np.abs(moment.qd) < 1e-9, 1e-9, moment.qd)
        torque = self._share * np.abs(moment.load) * np.tanh(v / TURN)
        return torque, torque / v


def presliding(slip: Floats, distance: Floats) -> Installed:
    """Install bristles of slip (6,) N·m that bend over a distance (6,) rad in all joints."""
    return Installed((Presliding(np.asarray(slip), np.asarray(distance)),))


def loaded_teeth(share: Floats) -> Installed:
    """Install dry friction of a share (6,) of each joint's load."""
    return Installed((LoadedTeeth(np.asarray(share)),))


def soft_gears(
    stiffness: Floats, parameters: ArmParameters, stiff: Collection[int] = ()
) -> Installed:
    """Install gears of a stiffness (6,) N·m/rad in all joints but those in `stiff`, 0 to 5."""
    inertia = parameters.reflected_inertia
    loss = 2.0 * DAMPING * np.sqrt(np.asarray(stiffness) * inertia)
    gears = [
        Gear(joint, float(stiffness[joint]), float(loss[joint]))
        for joint in range(len(JOINTS))
        if joint not in stiff
    ]
    return Installed(gears=tuple(gears))
