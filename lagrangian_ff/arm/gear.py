"""Gears that give way or have play: joints of two masses, the rotor and the link."""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.linalg.lapack import dposv

from lagrangian_ff.arm.description import JOINTS, Load
from lagrangian_ff.arm.joint_effect import JointEffect
from lagrangian_ff.arm.parameters import ArmParameters
from lagrangian_ff.arm.plant import ITERATIONS, Attached, Plant, settled

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
        count = len(JOINTS)
        self._rotor = count + np.arange(len(gears))
        # Where the motor, friction and effects of each joint act: on the rotor where it is free.
        self._seat = np.arange(count)
        self._seat[self._joint] = self._rotor
        # Rotor less link of each gear.
        self._apart = np.zeros((len(gears), count + len(gears)))
        self._apart[np.arange(len(gears)), self._rotor] = 1.0
        self._apart[np.arange(len(gears)), self._joint] = -1.0
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
        dt, count, rotor, seat, apart = self.dt, len(JOINTS), self._rotor, self._seat, self._apart
        mass, bias = self._body.dynamics(self.q, self.qd)
        inertia = np.zeros((apart.shape[1],) * 2)
        inertia[:count, :count] = mass
        diagonal = inertia.reshape(-1)[:: len(inertia) + 1]
        diagonal[seat] += self._armature
        start = np.concatenate([self.qd, self._rotor_qd[self._joint]])
        # Momentum at the end of the step, but for friction, effects and gears.
        momentum = inertia.dot(start)
        momentum[:count] -= dt * bias
        momentum[seat] += dt * motor
        twist = self._twist
        guess = start + self._change
        for _ in range(ITERATIONS):
            moving = guess[seat]
            slope = self.friction.chord(moving)
            resisting = slope * moving
            if self._effects:
                added, steeper = self._resistance(moving, motor)
                resisting, slope = resisting + added, slope + steeper
            rate = apart.dot(guess)
            torque, per_velocity = self._spring(twist + dt * rate, rate)
            system = inertia + apart.T.dot((dt * per_velocity)[:, None] * apart)
            system.reshape(-1)[:: len(system) + 1][seat] += dt * slope
            right = momentum + apart.T.dot(dt * (per_velocity * rate - torque))
            right[seat] += dt * (slope * moving - resisting)
            after = dposv(system, right)[1]
            change = after - guess
            guess = after
            if settled(change):
                break
        self._change = guess - start
        self.effect_torque = resisting + slope * change[seat]
        self.qdd = self._change[:count] / dt
        self.load_torque = bias + mass.dot(self.qdd)
        rotor_q = self._rotor_q[self._joint] + dt * guess[rotor]
        self._move(guess[:count])
        self._rotor_q, self._rotor_qd = self.q.copy(), self.qd.copy()
        self._rotor_q[self._joint], self._rotor_qd[self._joint] = rotor_q, guess[rotor]
        self._advance_effects(motor)

    @property
    def _twist(self) -> Floats:
        """Rad by which each rotor is ahead of its link."""
        return self._rotor_q[self._joint] - self.q[self._joint]

    def _spring(self, twist: Floats, rate: Floats) -> tuple[Floats, Floats]:
        """The torque from rotor to link at this twist, and its derivative by a step's velocity."""
        beyond = self._beyond(twist)
        touching = (beyond != 0.0) | (self._half == 0.0)
        torque = self._stiffness * beyond + self._damping * rate * touching
        return torque, (self._stiffness * self.dt + self._damping) * touching

    def _beyond(self, twist: Floats) -> Floats:
        """The twist beyond the play."""
        return twist - np.minimum(np.maximum(twist, -self._half), self._half)

    def energy(self) -> float:
        """J of links, rotors and springs, kinetic and potential, at the present state."""
        mass = self._body.mass_matrix(self.q)
        kinetic = 0.5 * (self.qd @ mass @ self.qd + self._armature @ self._rotor_qd**2)
        spring = 0.5 * float(self._stiffness @ self._beyond(self._twist) ** 2)
        return float(kinetic) + spring + self.body.potential_energy()
