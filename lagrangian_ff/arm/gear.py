"""Gears that give way or have play: joints of two masses, the rotor and the link."""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.linalg.lapack import dposv

from lagrangian_ff.arm.description import JOINTS, Load
from lagrangian_ff.arm.joint_effect import JointEffect
from lagrangian_ff.arm.parameters import ArmParameters
from lagrangian_ff.arm.plant import ITERATIONS, SETTLED, Attached, Plant

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
        self._joint = np.array([gear.joint for gear in gears], dtype=np.int64)
        self._stiffness = np.array([gear.stiffness for gear in gears])
        self._damping = np.array([gear.damping for gear in gears])
        self._half = 0.5 * np.array([gear.play for gear in gears])
        self._rotor = len(JOINTS) + np.arange(len(gears))
        super().__init__(parameters, loads, effects, attached)

    def reset(self, q: Floats) -> None:
        """Put links and rotors at rest at q, (6,) rad, without twist."""
        self._rotor_q = np.array(q, dtype=np.float64)
        self._rotor_qd = np.zeros(len(JOINTS))
        self._change = np.zeros(len(JOINTS) + len(self._joint))
        super().reset(q)

    @property
    def encoder(self) -> Floats:
        """See Plant."""
        return self._rotor_q

    @property
    def rotor_velocity(self) -> Floats:
        """See Plant."""
        return self._rotor_qd

    def step(self, motor: Floats) -> None:
        """See Plant."""
        self._take_up()
        count, joint, rotor = len(JOINTS), self._joint, self._rotor
        # Where the motor, friction and effects of each joint act: on the rotor where it is free.
        seat = np.arange(count)
        seat[joint] = rotor
        mass = self.body.mass_matrix(self.q)
        bias = self.body.bias(self.q, self.qd)
        inertia = np.zeros((count + len(joint),) * 2)
        inertia[:count, :count] = mass
        inertia[seat, seat] += self._armature
        drive = np.zeros(len(inertia))
        drive[:count] -= bias
        drive[seat] += motor
        start = np.concatenate([self.qd, self._rotor_qd[joint]])
        guess = start + self._change
        for _ in range(ITERATIONS):
            resisting, slope = self._resistance(guess[seat], motor)
            torque, per_velocity = self._twist(guess)
            force, system = np.zeros(len(inertia)), np.zeros_like(inertia)
            force[seat] += resisting
            force[rotor] += torque
            force[joint] -= torque
            system[seat, seat] += slope
            system[rotor, rotor] += per_velocity
            system[joint, joint] += per_velocity
            system[rotor, joint] -= per_velocity
            system[joint, rotor] -= per_velocity
            right = drive - force + system @ (guess - start)
            after = start + self.dt * dposv(inertia + self.dt * system, right)[1]
            change = after - guess
            guess = after
            if np.abs(change).max() < SETTLED:
                break
        self._change = guess - start
        self.effect_torque = resisting + slope * change[seat]
        self.qdd = self._change[:count] / self.dt
        self.load_torque = bias + mass @ self.qdd
        self.body.advance(self.load_torque)
        self.q, self.qd = self.body.state()
        rotor_q = self._rotor_q[joint] + self.dt * guess[rotor]
        self._rotor_q, self._rotor_qd = self.q.copy(), self.qd.copy()
        self._rotor_q[joint], self._rotor_qd[joint] = rotor_q, guess[rotor]
        self._advance_effects(motor)

    def _twist(self, velocity: Floats) -> tuple[Floats, Floats]:
        """The torque from rotor to link after a step at this velocity, and its derivative."""
        joint = self._joint
        rate = velocity[self._rotor] - velocity[joint]
        twist = self._rotor_q[joint] - self.q[joint] + self.dt * rate
        beyond = twist - np.clip(twist, -self._half, self._half)
        touching = (beyond != 0.0) | (self._half == 0.0)
        torque = self._stiffness * beyond + self._damping * rate * touching
        return torque, (self._stiffness * self.dt + self._damping) * touching

    def energy(self) -> float:
        """J of links, rotors and springs, kinetic and potential, at the present state."""
        mass = self.body.mass_matrix(self.q)
        twist = self._rotor_q[self._joint] - self.q[self._joint]
        beyond = twist - np.clip(twist, -self._half, self._half)
        kinetic = 0.5 * (self.qd @ mass @ self.qd + self._armature @ self._rotor_qd**2)
        spring = 0.5 * float(self._stiffness @ beyond**2)
        return float(kinetic) + spring + self.body.potential_energy()
