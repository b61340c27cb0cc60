"""Solid contacts in the joints: bristles, a differential pair, springs, soft gears and play."""

from math import copysign, exp, log10

import numpy as np
from numpy.typing import NDArray

from lagrangian_ff.arm.description import JOINTS
from lagrangian_ff.arm.gear import Gear
from lagrangian_ff.arm.hidden.base import Installed, OneJoint, Site, dry, partner
from lagrangian_ff.arm.joint_effect import JointMoment
from lagrangian_ff.arm.parameters import ArmParameters

Floats = NDArray[np.float64]


class Bristles(OneJoint):
    """Contacts that bend before they slip: dz/dt = v − |v| z / z_s, torque F z / z_s.

    Dahl's model (1968), the LuGre model without its speed dependence, solved exactly over a step
    of constant velocity: z goes to z_s sign(v) as e^(−|v| t / z_s).
    """

    def __init__(self, joint: int, slip: float, distance: float) -> None:
        super().__init__(joint)
        self._slip, self._distance = slip, distance
        self._bent = 0.0

    def reset(self, q: Floats) -> None:
        """See JointEffect."""
        self._bent = 0.0

    def _after(self, v: float, dt: float) -> tuple[float, float]:
        """The bend in parts of z_s after a step, and its derivative over v."""
        end = copysign(1.0, v)
        left = exp(-abs(v) * dt / self._distance)
        bent = end + (self._bent - end) * left
        return bent, (1.0 - end * self._bent) * left * dt / self._distance

    def law(self, v: float, moment: JointMoment) -> tuple[float, float]:
        """See OneJoint."""
        bent, slope = self._after(v, moment.dt)
        return self._slip * bent, self._slip * slope

    def advance(self, moment: JointMoment) -> None:
        """See JointEffect."""
        self._bent = self._after(float(moment.qd[self.joint]), moment.dt)[0]


def hysteresis(site: Site, strength: float) -> Installed:
    """Of strength N·m of slip; a presliding distance of 2 to 10 mrad."""
    distance = 10.0 ** site.random.uniform(log10(2e-3), -2.0)
    return Installed(
        (Bristles(site.joint, strength, distance),),
        facts={"slip torque [N·m]": strength, "presliding distance [rad]": distance},
    )


class Differential:
    """A bevel gear between two motors rubs at qd_j ± qd_k, and by virtual work brakes both.

    F sign(v_m) + B v_m on the first joint, the same times ±1 on the second.
    """

    def __init__(self, first: int, second: int, way: float, dry: float, viscous: float) -> None:
        self._row = np.zeros(len(JOINTS))
        self._row[first], self._row[second] = 1.0, way
        # The sum over both joints is bounded by twice the chord on each: the iteration is safe.
        self._bound = 2.0 * np.abs(self._row)
        self._dry, self._viscous = dry, viscous

    def reset(self, q: Floats) -> None:
        """See JointEffect."""

    def torque(self, moment: JointMoment) -> tuple[Floats, Floats]:
        """See JointEffect."""
        v = float(self._row @ moment.qd)
        chord = self._dry * dry(v)[1] + self._viscous
        return self._row * (chord * v), self._bound * chord

    def advance(self, moment: JointMoment) -> None:
        """See JointEffect."""


def coupled(site: Site, strength: float) -> Installed:
    """Of strength N·m between a joint and its partner."""
    second = partner(site.joint)
    way = float(site.random.choice((-1.0, 1.0)))
    return Installed(
        (Differential(site.joint, second, way, strength, 0.3 * strength),),
        facts={"dry [N·m]": strength, "viscous [N·m·s/rad]": 0.3 * strength, "sign": way},
    )


class Spring(OneJoint):
    """A hose or cable that is twisted: k x + k₃ x³ with x = q − q0."""

    def __init__(self, joint: int, stiffness: float, cubic: float, rest: float) -> None:
        super().__init__(joint)
        self._stiffness, self._cubic, self._rest = stiffness, cubic, rest

    def law(self, v: float, moment: JointMoment) -> tuple[float, float]:
        """See OneJoint."""
        x = float(moment.q[self.joint]) - self._rest
        return (self._stiffness + self._cubic * x * x) * x, 0.0


def spring(site: Site, strength: float) -> Installed:
    """Of strength N·m/rad, 0.3 of it per rad² more, at rest within 0.5 rad of zero."""
    rest = site.random.uniform(-0.5, 0.5)
    return Installed(
        (Spring(site.joint, strength, 0.3 * strength, rest),),
        facts={"stiffness [N·m/rad]": strength, "rest [rad]": rest},
    )


def elasticity(site: Site, strength: float) -> Installed:
    """A gear that the run's RMS torque twists by strength rad, with 4 % of critical damping."""
    torque = float(site.along.rms(site.along.motor)[site.joint])
    return _gear(site, torque / strength, 0.04, 0.0)


def backlash(site: Site, strength: float) -> Installed:
    """A play of strength rad; teeth that ring at 15 Hz with 40 % of critical damping."""
    inertia = float(ArmParameters().reflected_inertia[site.joint])
    return _gear(site, inertia * (2.0 * np.pi * 15.0) ** 2, 0.4, strength)


def _gear(site: Site, stiffness: float, damping: float, play: float) -> Installed:
    inertia = float(ArmParameters().reflected_inertia[site.joint])
    loss = 2.0 * damping * float(np.sqrt(stiffness * inertia))
    facts = {
        "stiffness [N·m/rad]": stiffness,
        "damping [N·m·s/rad]": loss,
        "play [rad]": play,
        "rotor against the link held [Hz]": float(np.sqrt(stiffness / inertia)) / (2.0 * np.pi),
    }
    return Installed(gears=(Gear(site.joint, stiffness, loss, play),), facts=facts)
