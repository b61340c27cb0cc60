"""The results of a diagnosis, which every reader may import."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TypeVar

import numpy as np

from lagrangian_ff.arrays import Floats
from lagrangian_ff.diagnosis import thresholds
from lagrangian_ff.diagnosis.confidence import Doubt, HoldOut, Reason, Verdict
from lagrangian_ff.diagnosis.consequence import Consequence
from lagrangian_ff.diagnosis.contacts import Contact
from lagrangian_ff.diagnosis.lag import Lag
from lagrangian_ff.diagnosis.misfit import Misfit
from lagrangian_ff.effects import EFFECTS, Curve, Effect, look_alikes
from lagrangian_ff.identification import Model
from lagrangian_ff.identification.build import seconds
from lagrangian_ff.identification.records import Estimate
from lagrangian_ff.recording.motion import Motion
from lagrangian_ff.words import which


@dataclass(frozen=True, eq=False)
class PartialResidual:
    """The partial residual: an effect's torque plus what the model leaves over, by bins.

    Attributes:
        coordinate, unit: in words.
        x: (B,) mean of the coordinate.
        residual, low, high: (B,) N·m, mean of the partial residual and the ends of a 90 % band.
        effect: (B,) N·m, mean torque of the effect.
    """

    coordinate: str
    unit: str
    x: Floats
    residual: Floats
    low: Floats
    high: Floats
    effect: Floats


@dataclass(frozen=True, eq=False, kw_only=True)
class Found:
    """The common part of a `Finding` and a load `TakenUp`, for readers that treat them alike.

    Attributes:
        effect: of the catalogue.
        joints: names of the joints whose torque it adds to, the most affected first.
        cause: the name of the joint whose hardware it is, mostly the same; None for none.
        shape: its nonlinear parameters, except those that each model searches for itself.
        parameters: by name.
        log_bayes_factor: nats.
        p_value: how often the null of the maximum over all candidates reaches it; None for what
            is not compared with that null.
        rivals: names of effects that explain the data as well.
        doubt: why it is only suggested; None if it is more.
        consequence: of adding it; None if it was not tried.
        partial_residual: its torque as the data show it; every `Finding` has it.
    """

    effect: Effect
    joints: tuple[str, ...]
    shape: Mapping[str, float]
    parameters: Mapping[str, Estimate]
    log_bayes_factor: float
    doubt: Doubt | None
    cause: str | None = None
    p_value: float | None = None
    rivals: tuple[str, ...] = ()
    consequence: Consequence | None = None
    partial_residual: PartialResidual | None = None

    @property
    def verdict(self) -> Verdict:
        """Return the verdict; ambiguous means that one of several effects is there."""
        if self.doubt is not None:
            return Verdict.SUGGESTED
        return Verdict.AMBIGUOUS if self.rivals else Verdict.CONFIRMED

    @property
    def said(self) -> str:
        """Return the verdict in words, with the rivals of an ambiguous one."""
        rivals = f" with {', '.join(self.rivals)}" if self.verdict is Verdict.AMBIGUOUS else ""
        return f"{self.verdict.value}{rivals}"

    @property
    def confirmed(self) -> bool:
        """Return whether the verdict is `CONFIRMED`."""
        return self.verdict is Verdict.CONFIRMED

    @property
    def useless(self) -> bool:
        """Return whether it is there, but adding it does not lower the error."""
        return self.doubt is not None and self.doubt.reason is Reason.NO_HELP

    @property
    def once(self) -> bool:
        """Return whether it is an event of the recording, not a property of the arm."""
        return self.effect.kind == "event"

    @property
    def errors(self) -> tuple[float | None, float | None]:
        """Return N·m before and after adding it, see `Consequence.joint`; None if not tried."""
        made = self.consequence
        return (made.whole_before, made.whole_after) if made else (None, None)

    @property
    def told_apart_by(self) -> tuple[str, ...]:
        """Return how to tell it from its rivals, as far as the catalogue knows."""
        known = look_alikes(self.effect)
        return tuple(known[name] for name in self.rivals if name in known)

    def place(self, every: Sequence[str]) -> str:
        """Return in words where it acts, and in whose gear if that is another joint's.

        Args:
            every: all joints of the arm.
        """
        cause = self.cause
        gear = f" (gear of {cause})" if cause and cause not in self.joints else ""
        return f"{which(self.joints, every)}{gear}"


@dataclass(frozen=True, eq=False, kw_only=True)
class Finding(Found):
    """An effect that is missing on one joint; its parameters are fitted together with all findings.

    Attributes:
        size: N·m, root mean square of its torque.
        hold_out: the judgement on motion that was not used to find it.
        ruled_out: names of rivals that the hold-out motion ruled out.
        stands: whether it is known of other motion, and this is not against it.
    """

    partial_residual: PartialResidual
    size: float
    hold_out: HoldOut
    ruled_out: tuple[str, ...]
    stands: bool = False

    @property
    def joint(self) -> str:
        """Return the name of its joint."""
        return self.joints[0]

    @property
    def name(self) -> str:
        """Return its name, as the history of a model has it."""
        return f"{self.effect.name} on {self.joint}"


@dataclass(frozen=True)
class Change:
    """A load taken up, or a contact.

    Attributes:
        since, until: s; infinite `until` means to the end.
        share: variance of the added torque relative to that of the rigid-body torque.
        log_bayes_factor: nats.
        since_range, until_range: s, 90 % intervals of both moments.
    """

    since: float
    until: float
    share: float
    log_bayes_factor: float
    since_range: tuple[float, float] = (-np.inf, np.inf)
    until_range: tuple[float, float] = (-np.inf, np.inf)

    @property
    def lasts(self) -> bool:
        """Return whether it lasts to the end."""
        return not np.isfinite(self.until)

    @property
    def effect(self) -> Effect:
        """Return the effect of the catalogue that describes it."""
        event = "lasting" if self.lasts else "passing"
        return next(one for one in EFFECTS.values() if one.arm_event == event)

    @property
    def prior(self) -> tuple[float, float, float]:
        """Return the change as `Problem` takes it."""
        return self.since, self.until, self.share


@dataclass(frozen=True, eq=False, kw_only=True)
class TakenUp(Found):
    """A load that the arm took up on the way; its parameters are the moments, in s.

    Attributes:
        change: its moments and its evidence.
        again: the load that the hold-out motion takes up; None if it takes up none.
    """

    change: Change
    again: Change | None


@dataclass(frozen=True)
class Unexplained:
    """A torque that depends on a coordinate in a way that no known effect fits.

    Attributes:
        joint: its name.  coordinate: in words.
        share: root mean square of this torque over that of the joint's torque.
        log_bayes_factor: nats.
        curve: which takes it into a model; None if no curve over two coordinates does.
        consequence: of adding this curve; None if it was not tried.
    """

    joint: str
    coordinate: str
    share: float
    log_bayes_factor: float
    curve: Curve | None = None
    consequence: Consequence | None = None


@dataclass(frozen=True)
class Remainder:
    """What is left on a joint and is more than noise, although nothing explains it.

    Attributes:
        joint: its name.
        size: N·m, root mean square without the noise.  share: of the joint's torque.
    """

    joint: str
    size: float
    share: float


@dataclass(frozen=True)
class NotObservable:
    """An effect that this motion cannot show.

    Attributes:
        effect, joint: their names.  reason: why it cannot.  next_motion: which one would.
    """

    effect: str
    joint: str
    reason: str
    next_motion: str


@dataclass(frozen=True)
class Ranked:
    """A candidate, before anything was found or beside all that was.

    Attributes:
        name: of the effect, or of a curve.  joint: its name.
        log_bayes_factor: nats, at its best shape.
        named: whether it is an effect of the catalogue.
        stands_out: whether it exceeds the threshold of the null.
    """

    name: str
    joint: str
    log_bayes_factor: float
    named: bool
    stands_out: bool


@dataclass(frozen=True, eq=False)
class Diagnosis:
    """The diagnosis of a model: what it lacks.

    Attributes:
        model: the diagnosed model.  motion: the searched motion.
        held_out: the motion to confirm on.  separate: whether it is another recording.
        findings: effects, best first.  unexplained: torques that no effect fits.
        taken_up: a load taken up on the way.  not_observable: effects that this motion cannot show.
        ranking, waiting: candidates before anything was found, and beside all that was, best first.
        threshold: nats that the maximum over all candidates exceeds by chance once in twenty times.
        noise: (N,) N·m, standard deviation of each joint's unexplained torque.
        wanting: s of such motion that a verdict needs besides; without them there is none.
        remainders: of the joints where that is more than the measurement's noise.
        missed: by joint, N·m rms that the model misses on `held_out`; empty if not looked at.
        misfit: the errors of the model on `motion` beside its own; None if they were not compared.
        contacts: touches, in their order.  lag: of all torques, which the findings allow for.
    """

    model: Model
    motion: Motion
    held_out: Motion
    separate: bool
    findings: tuple[Finding, ...]
    unexplained: tuple[Unexplained, ...]
    taken_up: TakenUp | None
    not_observable: tuple[NotObservable, ...]
    ranking: tuple[Ranked, ...]
    waiting: tuple[Ranked, ...]
    threshold: float
    noise: Floats
    wanting: float = 0.0
    remainders: tuple[Remainder, ...] = ()
    missed: Mapping[str, float] = field(default_factory=dict)
    misfit: Misfit | None = None
    contacts: tuple[Contact, ...] = ()
    lag: Lag | None = None

    @property
    def confirmed(self) -> tuple[Finding, ...]:
        """Return the confirmed findings."""
        return tuple(one for one in self.findings if one.confirmed)

    @property
    def tried(self) -> tuple[tuple[Finding, Consequence], ...]:
        """Return the confirmed findings that were added, each to those before it."""
        made = [(one, one.consequence) for one in self.confirmed]
        return tuple((one, consequence) for one, consequence in made if consequence is not None)

    @property
    def curves(self) -> tuple[tuple[Unexplained, Consequence], ...]:
        """Return what is unexplained and lowers the error as a curve, added after the findings."""
        tried = [(one, one.consequence) for one in self.unexplained]
        return tuple((one, made) for one, made in tried if made is not None and made.worth)

    @property
    def failing(self) -> Mapping[str, float]:
        """Return by joint the N·m rms that the model misses of `held_out` with all that was added.

        Only where that is so far above the joint's noise that the model does not know the arm.
        """
        missed = self.tried[-1][1].joints_after if self.tried else self.missed
        most = dict(zip(self.model.joints, thresholds.USED.fails * self.noise, strict=True))
        return {joint: error for joint, error in missed.items() if error > most[joint]}

    @property
    def found(self) -> tuple[Found, ...]:
        """Return the findings and the load taken up, best first."""
        return sorted_findings([*self.findings, *([self.taken_up] if self.taken_up else [])])

    @property
    def confirmed_on(self) -> str:
        """Return in words the motion that findings were confirmed on."""
        if self.separate:
            return self.held_out.source
        return f"the last {seconds(self.held_out):.0f} s, held back"


AnyFound = TypeVar("AnyFound", bound=Found)


def sorted_findings(findings: Sequence[AnyFound]) -> tuple[AnyFound, ...]:
    """Return the findings by verdict, the largest log Bayes factor first among equals."""
    order = list(Verdict)
    return tuple(sorted(findings, key=lambda f: (order.index(f.verdict), -f.log_bayes_factor)))
