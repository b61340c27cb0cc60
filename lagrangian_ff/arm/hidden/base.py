"""What a hidden effect is: physics that the arm's description does not mention, of known size."""

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from math import tanh
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from lagrangian_ff.arm.description import JOINTS
from lagrangian_ff.arm.gear import Gear
from lagrangian_ff.arm.joint_effect import JointEffect, JointMoment
from lagrangian_ff.arm.plant import Attached, true_torque
from lagrangian_ff.arm.servo import SensorEffect
from lagrangian_ff.arm.simulation import SETTLING, Run

Floats = NDArray[np.float64]

ALL_JOINTS = tuple(range(len(JOINTS)))


@dataclass(frozen=True)
class Reference:
    """A run along which an effect is sized, all on the links' side of the gears.

    Attributes:
        time: (M,) s since the beginning of the recording, evenly spaced.
        q: (M, 6) rad.  qd: (M, 6) rad/s.  qdd: (M, 6) rad/s².
        motor: (M, 6) N·m of the motors.  load: (M, 6) N·m that went into the links.
        ahead: (M, 6) rad of the motors ahead of the links; zero where gears are stiff.
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
        """What happened in a run."""
        time, q, qd = run.recording.time, run.position, run.velocity
        qdd = np.gradient(qd, time, axis=0)
        ahead = run.encoder - q
        return cls(time, q, qd, qdd, run.motor_torque, run.load_torque, ahead)

    @property
    def dt(self) -> float:
        """s between two samples."""
        return float(self.time[1] - self.time[0])

    def rms(self, torque: Floats) -> Floats:
        """(6,) N·m of torques (M, 6)."""
        return np.sqrt(np.mean(np.square(torque), axis=0))


@dataclass(frozen=True)
class Installed:
    """The parts of an arm that make one hidden effect; see `simulate` for each.

    Attributes:
        facts: what the effect's numbers are, by name with unit, for the record.
    """

    effects: tuple[JointEffect, ...] = ()
    sensors: tuple[SensorEffect, ...] = ()
    gears: tuple[Gear, ...] = ()
    attached: Attached | None = None
    facts: Mapping[str, float] = field(default_factory=dict)


@dataclass(frozen=True)
class Site:
    """Where and when an effect is put.

    Attributes:
        joint: 0 to 5.
        seed: of what chance decides about the effect (its phase, its harmonic, ...).
        recording: which recording of the same arm this is; only what happens by chance in time
            differs between them.
        along: what the arm does without the effect in the first recording; what an effect takes
            from it (a limit, an angle) is the same in all of them.
    """

    joint: int
    seed: int
    recording: int
    along: Reference

    @property
    def random(self) -> np.random.Generator:
        """Always from its beginning: the same draws at every strength and in every recording."""
        return np.random.default_rng(self.seed)

    @property
    def events(self) -> np.random.Generator:
        """As `random`, but of its own for each recording."""
        return np.random.default_rng([self.seed, self.recording])


Torque = Callable[[Installed, Site], Floats]


@dataclass(frozen=True)
class HiddenEffect:
    """One kind of hidden physics.

    Attributes:
        name: in this list.
        catalogue: the names of the catalogue of effects that are the right answer; empty for
            what no catalogue has.
        physics: one sentence.
        install: builds it at a site with a strength, in the unit of the effect.
        torque: (M, 6) N·m that the effect makes along the site's run: what the motors must give
            more, or for sensors, what the reported motion needs more than was reported.
        joints: where it can be, 0 to 5.
        reach: which joints it acts on when it is put on one: that one, that one and its
            `partner`, or the whole arm.
        absorbed: whether a kernel that can be any Lagrangian holds it already, so that finding
            nothing is right too.
        largest: the largest size that is still plausible for a machine.
        start: a strength to begin the sizing from.
        strongest: beyond this the physics is impossible; sizing stops here.
    """

    name: str
    catalogue: tuple[str, ...]
    physics: str
    install: Callable[[Site, float], Installed]
    torque: Torque
    joints: tuple[int, ...] = ALL_JOINTS
    reach: Literal["joint", "pair", "arm"] = "joint"
    absorbed: bool = False
    largest: float = 0.2
    start: float = 1.0
    strongest: float = np.inf

    def acts_on(self, joint: int) -> tuple[int, ...]:
        """The joints, 0 to 5, that feel it when it is put on one."""
        pair = (joint, partner(joint))
        return {"joint": (joint,), "pair": pair, "arm": ALL_JOINTS}[self.reach]


def partner(joint: int) -> int:
    """The neighbour that a joint shares something with: the next one, the last the one before."""
    return joint + 1 if joint + 1 < len(JOINTS) else joint - 1


class OneJoint(ABC):
    """A JointEffect on a single joint, written with plain numbers."""

    def __init__(self, joint: int) -> None:
        self.joint = joint

    def reset(self, q: Floats) -> None:  # noqa: B027 - most have no state
        """See JointEffect."""

    @abstractmethod
    def law(self, v: float, moment: JointMoment) -> tuple[float, float]:
        """Torque in N·m and slope in N·m·s/rad at velocity v, see JointEffect.torque."""

    def torque(self, moment: JointMoment) -> tuple[Floats, Floats]:
        """See JointEffect."""
        torque, slope = np.zeros(len(JOINTS)), np.zeros(len(JOINTS))
        joint = self.joint
        torque[joint], slope[joint] = self.law(float(moment.qd[joint]), moment)
        return torque, slope

    def advance(self, moment: JointMoment) -> None:  # noqa: B027 - most have no state
        """See JointEffect."""


def dry(v: float, turn: float = 0.02) -> tuple[float, float]:
    """A smooth sign of v that turns over at `turn` rad/s, and its chord to the origin."""
    x = v / turn
    if abs(x) < 1e-6:
        return x, 1.0 / turn
    sign = tanh(x)
    return sign, sign / v


def recorded(moment: JointMoment) -> float:
    """s since the beginning of the recording, which follows the arm's settling."""
    return moment.time - SETTLING


def replay(installed: Installed, site: Site) -> Floats:
    """(M, 6) N·m of the joint effects along the site's run, their states advanced sample by sample.

    The site's own motion is taken as given: what the effect would do to it is not counted.
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


def unexplained_by(site: Site, q: Floats, qd: Floats, qdd: Floats) -> Floats:
    """(M, 6) N·m that the run's motion needs more than another motion, as it was reported.

    By the arm's own inverse dynamics with friction, at 100 Hz.
    """
    run, every = site.along, 5
    part = slice(None, None, every)
    true = true_torque(run.q[part], run.qd[part], run.qdd[part])
    seen = true_torque(q[part], qd[part], qdd[part])
    return (true - seen)[np.minimum(np.arange(len(run.q)) // every, len(true) - 1)]
