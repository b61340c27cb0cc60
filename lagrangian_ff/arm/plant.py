"""The plant: links by PyBullet; rotors, gears, friction and joint effects that PyBullet lacks."""

from collections.abc import Mapping, Sequence
from contextlib import closing
from struct import Struct
from typing import NamedTuple

import numpy as np

from lagrangian_ff.arm.body import Body
from lagrangian_ff.arm.description import JOINTS, Load, Loads, limits
from lagrangian_ff.arm.joint_effect import Friction, JointEffect, JointMoment
from lagrangian_ff.arm.parameters import ArmParameters
from lagrangian_ff.arrays import Floats
from lagrangian_ff.errors import ArmError
from lagrangian_ff.loops import loop

ITERATIONS = 8
SETTLED = 1e-6  # rad/s

PER_JOINT = "f8", len(JOINTS)
TORQUES = "motor", "effect", "added_torque", "load"
MOTION = "q", "rotor_q", "qd"
RESULTS = *TORQUES, *MOTION, "rotor_qd", "qdd"
NUMBERS = np.dtype(
    [
        ("dt", "f8"),
        ("tolerance", "f8"),
        *((name, *PER_JOINT) for name in ("lower", "upper", "armature", "viscous", "steepest")),
        *((name, *PER_JOINT) for name in ("per_velocity", "stiffness", "damping", "half_play")),
        *((name, *PER_JOINT) for name in ("added", "slope", "guess", "rotor_guess")),
        ("unsettled", "f8"),
        ("change", *PER_JOINT),
        ("rotor_change", *PER_JOINT),
        ("at_stop", "f8"),
        ("mass", "f8", (len(JOINTS), len(JOINTS))),
        *((name, *PER_JOINT) for name in ("bias", *RESULTS)),
    ]
)
"""The data of `loops/arm.c`."""
_GIVEN = Struct(f"{len(JOINTS) * (len(JOINTS) + 2)}d")  # mass, bias and motor


_TORQUES, _MOTION = len(TORQUES), len(TORQUES) + len(MOTION)


def _result(name: str) -> property:
    """Return a property that reads one result of the last step."""
    row = RESULTS.index(name)

    def read(plant: "Plant") -> Floats:
        return plant._now[row]

    return property(read)


class Attached(NamedTuple):
    """Loads that an arm picks up while it moves.

    Attributes:
        time: s since the reset, when the arm picks them up.
        loads: kg (or Load) by joint or link: all that it carries from then on.
    """

    time: float
    loads: Mapping[str, float | Load]


class Gear(NamedTuple):
    """The gear between the rotor and the link of one joint, elastic or with play.

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


class Plant:
    """The arm from motor torque to motion.

    Each step solves (M + A) qdd + h + f = tau for qdd, with mass matrix M and bias h by PyBullet, A
    the reflected rotor inertia and f the joint effects at the *new* velocity (backward Euler: stiff
    friction stays stable); the new velocity then moves the joints. When a joint is at its stop,
    PyBullet takes the step, under the torque h + M qdd.

    A joint with a `Gear` has two masses (Spong, J. Dyn. Sys. Meas. Control 109, 1987): the rotor
    obeys g²J qdd_m + f(qd_m) = tau − s and the link M qdd + h = s. A spring and a damper over the
    twist q_m − q beyond the play give s (Nordin and Gutman, Automatica 38, 2002). Friction
    and effects act on the rotor's side, as do encoder and back-EMF.

    Args:
        parameters: masses, rotors, friction and the rate of the integration.
        loads: on the links, from the beginning.
        effects: in the joints, besides viscous and Coulomb friction.
        attached: loads that replace `loads` at a later time.
        gears: at most one a joint; the other joints are stiff.

    Attributes:
        time: s since the reset.
        q: (6,) rad.  qd: (6,) rad/s.
        qdd: (6,) rad/s² of the last step.
        encoder: (6,) rad of the motors through their gears.  rotor_velocity: (6,) rad/s of them.
        motion: (3, 6) positions of links and rotors, rad, velocities of the links, rad/s.
        torques: (4, 6) N·m of the motors, and the three below, in the last step.
        effect_torque: (6,) N·m that friction and effects took from the motors in the last step.
        added_torque: (6,) N·m of it that went to the effects besides friction.
        load_torque: (6,) N·m that went into the links in the last step.
    """

    def __init__(
        self,
        parameters: ArmParameters | None = None,
        loads: Loads = None,
        effects: Sequence[JointEffect] = (),
        attached: Attached | None = None,
        gears: Sequence[Gear] = (),
    ) -> None:
        self.parameters = parameters or ArmParameters()
        self.dt = 1.0 / self.parameters.physics_rate
        masses = self.parameters.link_masses
        self._bodies = [Body(loads, dt=self.dt, masses=masses)]
        if attached is not None:
            self._bodies.append(Body(attached.loads, dt=self.dt, masses=masses))
        self._attached_at = np.inf if attached is None else attached.time
        self._body = self._bodies[0]
        self.friction = Friction(self.parameters)
        self._effects = tuple(effects)
        self._armature = self.parameters.reflected_inertia
        self._lay_out()
        for gear in gears:
            self._numbers["stiffness"][gear.joint] = gear.stiffness
            self._numbers["damping"][gear.joint] = gear.damping
            self._numbers["half_play"][gear.joint] = 0.5 * gear.play
        self.reset(np.zeros(len(JOINTS)))

    def reset(self, q: Floats) -> None:
        """Put the arm at rest at q, (6,) rad."""
        self.time = 0.0
        self._numbers["change"] = self._numbers["rotor_change"] = 0.0
        self._results[:] = 0.0
        self._numbers["q"] = self._numbers["rotor_q"] = q
        self._read()
        self._body = self._bodies[0]
        for effect in self._effects:
            effect.reset(self.q)

    def _lay_out(self) -> None:
        """Fill in the data of the loops in C, and keep views of them."""
        numbers = self._numbers = np.zeros((), NUMBERS)
        numbers["dt"], numbers["tolerance"] = self.dt, SETTLED
        numbers["lower"], numbers["upper"], *_ = limits()
        numbers["armature"] = self._armature
        for name, values in self.friction.numbers.items():
            numbers[name] = values
        flat = numbers.reshape(1).view(np.float64)
        self._results = flat[-len(RESULTS) * len(JOINTS) :].reshape(len(RESULTS), -1)
        self._given = flat[-(len(JOINTS) + 1 + len(RESULTS)) * len(JOINTS) :].data.cast("B")
        self._guess, self._unsettled = numbers["rotor_guess"], numbers["unsettled"]
        self._added, self._slope = numbers["added"], numbers["slope"]
        self._at_stop = numbers["at_stop"]
        self._address = numbers.ctypes.data
        self._step, self._guess_first, self._settle, self._move = (
            loop(name) for name in ("arm_step", "arm_guess", "arm_settle", "arm_move")
        )

    def _read(self) -> None:
        """Copy the results of the step to new arrays."""
        self._now = self._results.copy()
        self.torques, self.motion = self._now[:_TORQUES], self._now[_TORQUES:_MOTION]

    q = _result("q")
    qd = _result("qd")
    qdd = _result("qdd")
    effect_torque = _result("effect")
    added_torque = _result("added_torque")
    load_torque = _result("load")
    encoder = _result("rotor_q")
    rotor_velocity = _result("rotor_qd")

    @property
    def body(self) -> Body:
        """Return the links in PyBullet, in the present state."""
        self._body.set_state(self.q, self.qd)
        return self._body

    def step(self, motor: Floats) -> None:
        """Let the motors give (6,) N·m through the gears for one step of the integration."""
        if self.time >= self._attached_at:
            self._body = self._bodies[-1]
        (a, b, c, d, e, f), bias = self._body.dynamics(self.q.tolist(), self.qd.tolist())
        # Making arrays of them would take ten times as long.
        _GIVEN.pack_into(self._given, 0, *a, *b, *c, *d, *e, *f, *bias, *motor.tolist())
        if self._effects:
            self._step_with_effects(motor)
        else:
            self._step(self._address, ITERATIONS)
        if self._at_stop:
            self._stop()
        self.time += self.dt
        self._read()
        if self._effects:
            rotor = self.encoder, self.rotor_velocity
            moment = JointMoment(self.time, self.dt, *rotor, motor, self.load_torque)
            for effect in self._effects:
                effect.advance(moment)

    def _step_with_effects(self, motor: Floats) -> None:
        """Evaluate the effects at every guess of the velocity."""
        q, load = self.encoder, self.load_torque
        first, *further = self._effects
        self._guess_first(self._address)
        for _ in range(ITERATIONS):
            moment = JointMoment(self.time, self.dt, q, self._guess.copy(), motor, load)
            self._added[:], self._slope[:] = first.torque(moment)
            for effect in further:
                torque, slope = effect.torque(moment)
                self._added += torque
                self._slope += slope
            self._settle(self._address, 1)
            if self._unsettled.item() < SETTLED:
                break
        self._move(self._address, 1)

    def _stop(self) -> None:
        """Let PyBullet, which has stops, move the links in this step."""
        body, numbers = self.body, self._numbers
        body.advance(numbers["load"])
        numbers["q"], numbers["qd"] = body.state()
        rigid = numbers["stiffness"] == 0.0
        numbers["rotor_q"][rigid] = numbers["q"][rigid]
        numbers["rotor_qd"][rigid] = numbers["qd"][rigid]

    def true_torque(self, q: Floats, qd: Floats, qdd: Floats, *, friction: bool = True) -> Floats:
        """Return the motor torque through the gears for this motion, without further effects.

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
    loads: Loads = None,
    friction: bool = True,
    parameters: ArmParameters | None = None,
) -> Floats:
    """Return the plant's own inverse dynamics, the ideal feedforward; see Plant.true_torque."""
    with closing(Plant(parameters, loads)) as plant:
        return plant.true_torque(q, qd, qdd, friction=friction)
