"""The plant: links by PyBullet; rotors, friction and joint effects that PyBullet lacks."""

from collections.abc import Mapping, Sequence
from operator import lt
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.linalg.lapack import dposv

from lagrangian_ff.arm.body import Body
from lagrangian_ff.arm.description import JOINTS, Load, limits
from lagrangian_ff.arm.joint_effect import Friction, JointEffect, JointMoment
from lagrangian_ff.arm.parameters import ArmParameters
from lagrangian_ff.errors import ArmError

Floats = NDArray[np.float64]

ITERATIONS = 8
SETTLED = 1e-6  # rad/s


def settled(change: Floats) -> bool:
    """Whether no velocity changed by more than what ends the iteration."""
    # Six numbers: half the time of np.abs(change).max().
    return max(map(abs, change.tolist())) < SETTLED


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

    Each step solves (M + A) qdd + h + f = tau for qdd, with mass matrix M and bias h by PyBullet, A
    the reflected rotor inertia and f the joint effects at the *new* velocity (backward Euler: stiff
    friction stays stable); the new velocity then moves the joints. Where one is at its stop,
    PyBullet takes the step, under the torque h + M qdd.

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
        self._body = self._bodies[0]
        self.friction = Friction(self.parameters)
        self._effects = tuple(effects)
        self._armature = self.parameters.reflected_inertia
        self._rotors = np.diag(self._armature)
        self._stops = limits().lower.tolist(), limits().upper.tolist()
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
        self._body = self._bodies[0]
        for effect in self._effects:
            effect.reset(self.q)

    @property
    def body(self) -> Body:
        """The links in PyBullet, in the present state."""
        self._body.set_state(self.q, self.qd)
        return self._body

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
        mass, bias = self._body.dynamics(self.q, self.qd)
        inertia = mass + self._rotors
        # (M + A) qd at the end of the step, but for friction and effects.
        momentum = inertia.dot(self.qd) + self.dt * (motor - bias)
        qd = self._settle(inertia, momentum, motor)
        self.qdd = (qd - self.qd) / self.dt
        self.load_torque = bias + mass.dot(self.qdd)
        self.effect_torque = motor - self.load_torque - self._armature * self.qdd
        self._move(qd)
        self._advance_effects(motor)

    def _settle(self, inertia: Floats, momentum: Floats, motor: Floats) -> Floats:
        """The velocity (6,) rad/s at the end of the step, at which the resisting torque acts."""
        dt, friction = self.dt, self.friction
        system = inertia.copy()
        diagonal, own = system.reshape(-1)[:: len(system) + 1], inertia.diagonal()
        right = momentum
        guess = self.qd + dt * self.qdd
        for _ in range(ITERATIONS):
            slope = friction.chord(guess)
            if self._effects:
                added, steeper = self._resistance(guess, motor)
                slope += steeper
                right = momentum + dt * (steeper * guess - added)
            np.add(own, dt * slope, out=diagonal)
            before, guess = guess, dposv(system, right)[1]
            if settled(guess - before):
                break
        return guess

    def _take_up(self) -> None:
        """Change to the body with the attached loads when its time has come."""
        if self.time >= self._attached_at:
            self._body = self._bodies[-1]

    def _move(self, qd: Floats) -> None:
        """Let the links move at the new velocity, (6,) rad/s; stops by PyBullet."""
        low, high = self._stops
        at = self.q.tolist()
        if all(map(lt, low, at)) and all(map(lt, at, high)):
            self.q, self.qd = self.q + self.dt * qd, qd
        else:
            body = self.body
            body.advance(self.load_torque)
            self.q, self.qd = body.state()

    def _advance_effects(self, motor: Floats) -> None:
        """Let the clock and the states of the effects catch up with the motion."""
        self.time += self.dt
        if not self._effects:
            return
        q, qd = self.encoder, self.rotor_velocity
        self.added_torque = self.effect_torque - self.friction.at(qd)
        moment = JointMoment(self.time, self.dt, q, qd, motor, self.load_torque)
        for effect in self._effects:
            effect.advance(moment)

    def _resistance(self, qd: Floats, motor: Floats) -> tuple[Floats, Floats]:
        """Torque and slope of the effects besides friction, of which there is one at least."""
        moment = JointMoment(self.time, self.dt, self.encoder, qd, motor, self.load_torque)
        torque, slope = self._effects[0].torque(moment)
        for effect in self._effects[1:]:
            more, steeper = effect.torque(moment)
            torque, slope = torque + more, slope + steeper
        return torque, slope

    def energy(self) -> float:
        """J of links and rotors, kinetic and potential, at the present state."""
        inertia = self._body.mass_matrix(self.q) + self._rotors
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
        torque = self._body.inverse_dynamics(*rows) + self._armature * rows[2]
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
