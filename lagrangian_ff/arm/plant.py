"""The plant: links by PyBullet; rotors, friction and joint effects that PyBullet lacks."""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.linalg.lapack import dposv

from lagrangian_ff.arm.body import Body
from lagrangian_ff.arm.description import JOINTS, Load
from lagrangian_ff.arm.joint_effect import Friction, JointEffect, JointMoment
from lagrangian_ff.arm.parameters import ArmParameters
from lagrangian_ff.errors import ArmError

Floats = NDArray[np.float64]

DIAGONAL = slice(None, None, len(JOINTS) + 1)
ITERATIONS = 8
SETTLED = 1e-6  # rad/s


class Attached(NamedTuple):
    """Loads that an arm takes up while it moves.

    Attributes:
        time: s since the reset, from when on the arm carries them.
        loads: kg (or Load) by joint or link: all that it carries from then on.
    """

    time: float
    loads: Mapping[str, float | Load]


class Plant:
    """The arm from motor torque to motion.

    Each step solves (M + A) qdd + h + f = tau for qdd, A the reflected rotor inertia and f the
    joint effects at the *new* velocity (backward Euler: stiff friction stays stable), and hands
    PyBullet the torque h + M qdd that gives its links this acceleration.

    Args:
        parameters: rotors, friction and the rate of the integration.
        loads: kg (or Load) by joint or link.
        effects: what acts in the joints besides viscous and Coulomb friction.
        attached: loads that take the place of `loads` at a later time.

    Attributes:
        time: s since the reset.
        q: (6,) rad.  qd: (6,) rad/s.
        qdd: (6,) rad/s² of the last step.
        effect_torque: (6,) N·m that friction and effects took from the motors in the last step.
        added_torque: (6,) N·m of it that went to the effects besides friction.
        load_torque: (6,) N·m that went into the links in the last step.
    """

    def __init__(
        self,
        parameters: ArmParameters | None = None,
        loads: Mapping[str, float | Load] | None = None,
        effects: Sequence[JointEffect] = (),
        attached: Attached | None = None,
    ) -> None:
        self.parameters = parameters or ArmParameters()
        self.dt = 1.0 / self.parameters.physics_rate
        self._bodies = [Body(loads, dt=self.dt)]
        if attached is not None:
            self._bodies.append(Body(attached.loads, dt=self.dt))
        self._attached_at = np.inf if attached is None else attached.time
        self.body = self._bodies[0]
        self.friction = Friction(self.parameters)
        self._effects: tuple[JointEffect, ...] = (self.friction, *effects)
        self._armature = self.parameters.reflected_inertia
        self.reset(np.zeros(len(JOINTS)))

    def reset(self, q: Floats) -> None:
        """Put the arm at rest at q, (6,) rad."""
        self.time = 0.0
        self.q = np.array(q, dtype=np.float64)
        self.qd = np.zeros(len(JOINTS))
        self.qdd = np.zeros(len(JOINTS))
        self.effect_torque = np.zeros(len(JOINTS))
        self.added_torque = np.zeros(len(JOINTS))
        self.load_torque = np.zeros(len(JOINTS))
        self.body = self._bodies[0]
        self.body.set_state(self.q, self.qd)
        for effect in self._effects:
            effect.reset(self.q)

    @property
    def encoder(self) -> Floats:
        """(6,) rad of the motors through their gears, which is where the encoders sit."""
        return self.q

    @property
    def rotor_velocity(self) -> Floats:
        """(6,) rad/s of the motors through their gears."""
        return self.qd

    def step(self, motor: Floats) -> None:
        """Let the motors act for one step of the integration.

        Args:
            motor: (6,) N·m through the gears.
        """
        self._take_up()
        mass = self.body.mass_matrix(self.q)
        bias = self.body.bias(self.q, self.qd)
        inertia = mass.copy()
        inertia.ravel()[DIAGONAL] += self._armature
        drive = motor - bias
        guess = self.qd + self.dt * self.qdd
        for _ in range(ITERATIONS):
            resisting, slope = self._resistance(guess, motor)
            system = inertia.copy()
            system.ravel()[DIAGONAL] += self.dt * slope
            qdd = dposv(system, drive - resisting + slope * (guess - self.qd))[1]
            qd = self.qd + self.dt * qdd
            change = qd - guess
            guess = qd
            if np.abs(change).max() < SETTLED:
                break
        self.effect_torque = resisting + slope * change
        self.load_torque = bias + mass @ qdd
        self.qdd = qdd
        self.body.advance(self.load_torque)
        self.q, self.qd = self.body.state()
        self._advance_effects(motor)

    def _take_up(self) -> None:
        """Change to the body with the attached loads when its time has come."""
        if self.time >= self._attached_at and self.body is not self._bodies[-1]:
            self.body = self._bodies[-1]
            self.body.set_state(self.q, self.qd)

    def _advance_effects(self, motor: Floats) -> None:
        """Let the clock and the states of the effects catch up with the motion."""
        q, qd = self.encoder, self.rotor_velocity
        if len(self._effects) > 1:
            self.added_torque = self.effect_torque - self.friction.at(qd)
        self.time += self.dt
        for effect in self._effects:
            effect.advance(JointMoment(self.time, self.dt, q, qd, motor, self.load_torque))

    def _resistance(self, qd: Floats, motor: Floats) -> tuple[Floats, Floats]:
        moment = JointMoment(self.time, self.dt, self.encoder, qd, motor, self.load_torque)
        torque, slope = self._effects[0].torque(moment)
        for effect in self._effects[1:]:
            more, steeper = effect.torque(moment)
            torque, slope = torque + more, slope + steeper
        return torque, slope

    def energy(self) -> float:
        """J of links and rotors, kinetic and potential, at the present state."""
        inertia = self.body.mass_matrix(self.q) + np.diag(self._armature)
        return float(0.5 * self.qd @ inertia @ self.qd) + self.body.potential_energy()

    def true_torque(self, q: Floats, qd: Floats, qdd: Floats, *, friction: bool = True) -> Floats:
        """The motor torque through the gears that makes this motion, without further effects.

        Args:
            q: (M, 6) or (6,) rad.  qd: rad/s, qdd: rad/s², of the same shape.
            friction: whether viscous and Coulomb friction are counted.

        Returns:
            N·m, of the same shape: the links by PyBullet's inverse dynamics, the rotors g²J qdd
            and the friction.

        Raises:
            ArmError: shapes that differ or do not end in 6, or a value that is not finite.
        """
        states = [np.asarray(x, dtype=np.float64) for x in (q, qd, qdd)]
        shape = states[0].shape
        if len({x.shape for x in states}) > 1 or not shape or shape[-1] != len(JOINTS):
            raise ArmError(
                f"true torque: expected q, qd and qdd of one shape (samples, {len(JOINTS)}), "
                f"got {', '.join(str(x.shape) for x in states)}"
            )
        rows = [x.reshape(-1, len(JOINTS)) for x in states]
        for name, row in zip(("q", "qd", "qdd"), rows, strict=True):
            bad = np.argwhere(~np.isfinite(row))
            if bad.size:
                sample, joint = bad[0]
                raise ArmError(
                    f"true torque: {name} of {JOINTS[joint]} at sample {sample} is not finite"
                )
        torque = self.body.inverse_dynamics(*rows) + self._armature * rows[2]
        if friction:
            torque += self.friction.at(rows[1])
        return torque.reshape(shape)

    def close(self) -> None:
        """End PyBullet's world."""
        for body in self._bodies:
            body.close()


def true_torque(
    q: Floats,
    qd: Floats,
    qdd: Floats,
    *,
    parameters: ArmParameters | None = None,
    loads: Mapping[str, float | Load] | None = None,
    friction: bool = True,
) -> Floats:
    """The plant's own inverse dynamics, the bound for any feedforward; see Plant.true_torque."""
    plant = Plant(parameters, loads)
    try:
        return plant.true_torque(q, qd, qdd, friction=friction)
    finally:
        plant.close()
