"""Hidden effects: physics beyond the arm's description, of known size."""

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from math import tanh
from typing import Any, Literal

import numpy as np

from lagrangian_ff.arm.description import JOINTS
from lagrangian_ff.arm.joint_effect import JointEffect, JointMoment
from lagrangian_ff.arm.parameters import ArmParameters
from lagrangian_ff.arm.plant import Attached, Gear, true_torque
from lagrangian_ff.arm.servo import SensorEffect
from lagrangian_ff.arm.simulation import SETTLING, Run
from lagrangian_ff.arrays import Floats

ALL_JOINTS = tuple(range(len(JOINTS)))
TRIES = 12  # of a strength
CLOSE = 0.01  # of the size


@dataclass(frozen=True)
class Reference:
    """A run along which an effect is sized, all on the links' side of the gears.

    Attributes:
        time: (M,) s since the beginning of the recording, evenly spaced.
        q: (M, 6) rad.  qd: (M, 6) rad/s.  qdd: (M, 6) rad/s².
        motor: (M, 6) N·m of the motors.  load: (M, 6) N·m that went into the links.
        ahead: (M, 6) rad of the motors ahead of the links; zero for stiff gears.
    """

    time: Floats
    q: Floats
    qd: Floats
    qdd: Floats
    motor: Floats
    load: Floats
    ahead: Floats

    @classmethod
    def of(cls, run: Run) -> "Reference":
        """Return the reference of a run."""
        time, q, qd = run.recording.time, run.position, run.velocity
        qdd = np.gradient(qd, time, axis=0)
        ahead = run.encoder - q
        return cls(time, q, qd, qdd, run.motor_torque, run.load_torque, ahead)

    @property
    def dt(self) -> float:
        """Return the time between two samples, s."""
        return float(self.time[1] - self.time[0])

    def rms(self, torque: Floats) -> Floats:
        """Return the RMS, (6,) N·m, of torques (M, 6)."""
        return np.sqrt(np.mean(np.square(torque), axis=0))


@dataclass(frozen=True)
class Installed:
    """The parts of an arm that make one hidden effect; see `simulate` for each.

    Attributes:
        facts: the effect's parameters by name with unit, for the record.
    """

    effects: tuple[JointEffect, ...] = ()
    sensors: tuple[SensorEffect, ...] = ()
    gears: tuple[Gear, ...] = ()
    attached: Attached | None = None
    facts: Mapping[str, float] = field(default_factory=dict)


def together(parts: Sequence[Installed]) -> dict[str, Any]:
    """Return the parts of several effects as `simulate` takes them; one of them may be a load."""
    joined: dict[str, Any] = {
        name: [one for part in parts for one in getattr(part, name)]
        for name in ("effects", "sensors", "gears")
    }
    attached = next((part.attached for part in parts if part.attached is not None), None)
    return {**joined, "attached": attached}


@dataclass(frozen=True)
class Site:
    """The place of an effect: a joint and a recording.

    Attributes:
        joint: 0 to 5.
        seed: of the effect's random parameters (its phase, its harmonic, ...).
        recording: number of the recording of the same arm; only random events in time differ
            between recordings.
        along: the run without the effect in the first recording; parameters that depend on it
            (a limit, an angle) are the same in all recordings.
        parameters: of the arm.
    """

    joint: int
    seed: int
    recording: int
    along: Reference
    parameters: ArmParameters = field(default_factory=ArmParameters)

    @property
    def random(self) -> np.random.Generator:
        """Return a fresh generator: the same draws at every strength and in every recording."""
        return np.random.default_rng(self.seed)

    @property
    def events(self) -> np.random.Generator:
        """Return a fresh generator that differs between recordings."""
        return np.random.default_rng([self.seed, self.recording])


def partner(joint: int) -> int:
    """Return the neighbour of a joint: the next one, of the last the one before."""
    return joint + 1 if joint + 1 < len(JOINTS) else joint - 1


class OneJoint(JointEffect, ABC):
    """A JointEffect on a single joint, written with plain numbers."""

    def __init__(self, joint: int) -> None:
        self.joint = joint

    @abstractmethod
    def law(self, v: float, moment: JointMoment) -> tuple[float, float]:
        """Return torque in N·m and slope in N·m·s/rad at velocity v, see JointEffect.torque."""

    def torque(self, moment: JointMoment) -> tuple[Floats, Floats]:
        torque, slope = np.zeros(len(JOINTS)), np.zeros(len(JOINTS))
        joint = self.joint
        torque[joint], slope[joint] = self.law(float(moment.qd[joint]), moment)
        return torque, slope


class Law(OneJoint):
    """An effect without state, of a function for `law`."""

    def __init__(
        self, joint: int, law: Callable[[float, JointMoment], tuple[float, float]]
    ) -> None:
        super().__init__(joint)
        self._law = law

    def law(self, v: float, moment: JointMoment) -> tuple[float, float]:
        return self._law(v, moment)


def dry(v: float, turn: float = 0.02) -> tuple[float, float]:
    """Return a smooth sign of v that changes over `turn` rad/s, and its chord to the origin."""
    x = v / turn
    if abs(x) < 1e-6:
        return x, 1.0 / turn
    sign = tanh(x)
    return sign, sign / v


def rub(height: float, v: float) -> tuple[float, float]:
    """Return dry friction of a height in N·m at velocity v, and its slope."""
    sign, chord = dry(v)
    return height * sign, height * chord


def recorded(moment: JointMoment) -> float:
    """Return s since the beginning of the recording, which follows the arm's settling."""
    return moment.time - SETTLING


def replay(installed: Installed, site: Site) -> Floats:
    """Return (M, 6) N·m of the joint effects along the site's run, sample by sample.

    The run is given; it does not react to the effect.
    """
    run = site.along
    torque = np.zeros_like(run.q)
    for effect in installed.effects:
        effect.reset(run.q[0])
        for k, time in enumerate(run.time + SETTLING):
            moment = JointMoment(
                float(time), run.dt, run.q[k], run.qd[k], run.motor[k], run.load[k]
            )
            torque[k] += effect.torque(moment)[0]
            effect.advance(moment)
    return torque


Torque = Callable[[Installed, Site], Floats]


@dataclass(frozen=True)
class HiddenEffect:
    """One kind of hidden physics.

    Attributes:
        install: builds it at a site with a strength, in the unit of the effect.
        physics: one sentence.
        torque: (M, 6) N·m of the effect along the site's run: the additional torque of the motors,
            or for sensors, of the reported motion.
        known: whether the catalogue of effects has it.
        joints: possible ones, 0 to 5.
        reach: the joints it acts on: its own, its own and the `partner`, or the whole arm.
        absorbed: whether a kernel of any Lagrangian contains it, so that finding nothing is right
            too.
        largest: the largest plausible size.
        start: the strength at which sizing starts.
        strongest: the largest possible strength.
    """

    install: Callable[[Site, float], Installed]
    physics: str
    torque: Torque = replay
    known: bool = True
    joints: tuple[int, ...] = ALL_JOINTS
    reach: Literal["joint", "pair", "arm"] = "joint"
    absorbed: bool = False
    largest: float = 0.2
    start: float = 1.0
    strongest: float = np.inf

    @property
    def name(self) -> str:
        """Return the name of its function, the one in the catalogue of effects if it is known."""
        return self.install.__name__

    @property
    def catalogue(self) -> tuple[str, ...]:
        """Return the right names in the catalogue of effects; empty if it has none."""
        return (self.name,) if self.known else ()

    def acts_on(self, joint: int) -> tuple[int, ...]:
        """Return the joints, 0 to 5, that it acts on if installed on one."""
        pair = (joint, partner(joint))
        return {"joint": (joint,), "pair": pair, "arm": ALL_JOINTS}[self.reach]


def unexplained_by(
    site: Site, q: Floats, qd: Floats, qdd: Floats, *, links: bool = False
) -> Floats:
    """Return (M, 6) N·m that the run's motion needs more than the reported one.

    By the arm's own inverse dynamics, at 100 Hz.

    Args:
        links: whether only the links moved so, and the motors as reported: then neither friction
            nor the rotors' inertia differ.
    """
    run, every = site.along, 5
    part = slice(None, None, every)

    def needed(q: Floats, qd: Floats, qdd: Floats) -> Floats:
        states = q[part], qd[part], qdd[part]
        if not links:
            return true_torque(*states, parameters=site.parameters)
        whole = true_torque(*states, friction=False, parameters=site.parameters)
        return whole - site.parameters.reflected_inertia * states[2]

    true, seen = needed(run.q, run.qd, run.qdd), needed(q, qd, qdd)
    return (true - seen)[np.minimum(np.arange(len(run.q)) // every, len(true) - 1)]


def size(effect: HiddenEffect, installed: Installed, site: Site) -> float:
    """Return the RMS of the effect's torque over that of the joint's motor torque in the run."""
    run, j = site.along, site.joint
    return float(run.rms(effect.torque(installed, site))[j] / run.rms(run.motor)[j])


def beyond_friction(effect: HiddenEffect, installed: Installed, site: Site) -> float:
    """Return the RMS, N·m, of the effect's torque that plain friction cannot imitate.

    Plain friction is viscous and Coulomb friction of the joint, and a constant.
    """
    torque = effect.torque(installed, site)[:, site.joint]
    speed = site.along.qd[:, site.joint]
    plain = np.stack([speed, np.tanh(speed / 0.02), np.ones_like(speed)], axis=1)
    left = torque - plain @ np.linalg.lstsq(plain, torque, rcond=None)[0]
    return float(np.sqrt(np.mean(left**2)))


def sized(effect: HiddenEffect, site: Site, wanted: float) -> tuple[Installed, float]:
    """Install an effect so that it has the wanted size, such as 0.1, along the site's run.

    The size rises with the strength: a secant in logarithms, one step if it is proportional.

    Returns:
        The effect, and the strength it has: `strongest`, if that is not enough for the size.
    """
    strength, power = min(effect.start, effect.strongest), 1.0
    before: tuple[float, float] | None = None
    for _ in range(TRIES):
        installed = effect.install(site, strength)
        found = max(size(effect, installed, site), 1e-9)
        if abs(found / wanted - 1.0) < CLOSE:
            break
        if strength == effect.strongest and found < wanted:
            break
        if before is not None and strength != before[0] and found != before[1]:
            slope = np.log(found / before[1]) / np.log(strength / before[0])
            power = float(np.clip(slope, 0.25, 4.0))
        before = strength, found
        step = float(np.clip((wanted / found) ** (1.0 / power), 0.1, 10.0))
        strength = min(strength * step, effect.strongest)
    return installed, strength
