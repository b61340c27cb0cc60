"""Gears that give way or have play: joints of two masses, the rotor and the link."""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from lagrangian_ff.arm.description import Load
from lagrangian_ff.arm.joint_effect import JointEffect
from lagrangian_ff.arm.parameters import ArmParameters
from lagrangian_ff.arm.plant import Attached, Plant

Floats = NDArray[np.float64]


class Gear(NamedTuple):
    """What lies between the rotor and the link of one joint.

    Attributes:
        joint: 0 to 5.
        stiffness: N·m/rad of the twist beyond the play, at the joint.
        damping: N·m·s/rad of that twist.
        play: rad, the whole dead zone at the joint; 0 for none.
    """

    joint: int
    stiffness: float
    damping: float
    play: float = 0.0


class GearedPlant(Plant):
    """The arm where some rotors turn apart from their links.

    A joint of two masses (Spong, J. Dyn. Sys. Meas. Control 109, 1987): the rotor obeys
    g²J qdd_m + f(qd_m) = tau − s and the link M qdd + h = s, with s the torque of a spring and a
    damper over the twist q_m − q beyond the play (Nordin and Gutman, Automatica 38, 2002).
    Friction and effects sit on the rotor's side, as do encoder and back-EMF. Backward Euler in
    the velocities of links and rotors together.

    Args:
        parameters, loads, effects, attached: see Plant.
        gears: at most one a joint; the other joints are stiff.
    """

    def __init__(
        self,
        parameters: ArmParameters | None = None,
        loads: Mapping[str, float | Load] | None = None,
        effects: Sequence[JointEffect] = (),
        attached: Attached | None = None,
        gears: Sequence[Gear] = (),
    ) -> None:
        super().__init__(parameters, loads, effects, attached)
        for gear in gears:
            self._numbers["stiffness"][gear.joint] = gear.stiffness
            self._numbers["damping"][gear.joint] = gear.damping
            self._numbers["half_play"][gear.joint] = 0.5 * gear.play

    def energy(self) -> float:
        """J of links, rotors and springs, kinetic and potential, at the present state."""
        mass, half = self._body.mass_matrix(self.q), self._numbers["half_play"]
        twist = self._rotor_q - self.q
        beyond = twist - np.clip(twist, -half, half)
        kinetic = 0.5 * (self.qd @ mass @ self.qd + self._armature @ self._rotor_qd**2)
        spring = 0.5 * float(self._numbers["stiffness"] @ beyond**2)
        return float(kinetic) + spring + self.body.potential_energy()
