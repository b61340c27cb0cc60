"""From a model and a recording to the physical effects that the model lacks."""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lagrangian_ff.diagnosis.ground import Ground, tune
from lagrangian_ff.diagnosis.search.change import AGAIN, Change, change_of, joints_of
from lagrangian_ff.diagnosis.search.confirm import Trial, Unseen
from lagrangian_ff.diagnosis.search.forward import MOST_STEPS, Search, Step, search
from lagrangian_ff.diagnosis.search.observable import NotObservable, not_observable
from lagrangian_ff.diagnosis.search.rivals import rivals
from lagrangian_ff.diagnosis.search.unnamed import told
from lagrangian_ff.effects import Effect
from lagrangian_ff.errors import RecordingError
from lagrangian_ff.identification import Model, kept
from lagrangian_ff.identification.basis import Basis
from lagrangian_ff.identification.build import seconds
from lagrangian_ff.identification.sliding import sliding_of
from lagrangian_ff.progress import Progress, part, silent
from lagrangian_ff.recording.motion import Motion, concatenate

Floats = NDArray[np.float64]

CONFIRMED, SUGGESTED, AMBIGUOUS = "confirmed", "suggested", "ambiguous"
SHORTEST = 6.0  # s
HELD_BACK = 1.0 / 3.0
"""Share of the only recording, from its end, that confirms what the rest suggests."""
LARGE_REST = 0.5
"""A name is no more than suggested where a free curve still gains this share of what it did."""


@dataclass(frozen=True, eq=False)
class Finding:
    """An effect that is missing.

    Attributes:
        step: how it was found.
        joint: the name of the joint whose torque it adds to.
        cause: the name of the joint whose hardware it is, mostly the same.
        parameters: (P,) frozen, with all that was found in the model.
        low, high: (P,) ends of their 90 % intervals.
        trial: how it did on motion that was not used to find it.
        rivals: names of what the data cannot tell from it.
        verdict: `confirmed`, `ambiguous` (one of several is there) or `suggested`.
        reason: why it is no more than suggested.
    """

    step: Step
    joint: str
    cause: str
    parameters: Floats
    low: Floats
    high: Floats
    trial: Trial
    rivals: tuple[str, ...]
    verdict: str
    reason: str

    @property
    def effect(self) -> Effect:
        """Which."""
        return self.step.score.candidate.effect

    @property
    def shape(self) -> Mapping[str, float]:
        """Its nonlinear parameters, but for those that each model searches for itself."""
        return self.effect.transferable(self.step.score.candidate.shape)


@dataclass(frozen=True)
class TakenUp:
    """A load that the arm took up on the way.

    Attributes:
        change: when, and what knowing it is worth.
        joints: that feel it, the most affected first.
        again: where the unseen motion takes one up; None: nowhere.
        verdict, reason: as of a finding.
    """

    change: Change
    joints: tuple[str, ...]
    again: Change | None
    verdict: str
    reason: str

    @property
    def shape(self) -> dict[str, float]:
        """When it happens, as the effect of the catalogue takes it."""
        if self.change.name == "payload":
            return {"t0": self.change.since}
        return {"t0": self.change.since, "length": self.change.until - self.change.since}

    @property
    def ranges(self) -> dict[str, tuple[float, float]]:
        """The 90 % intervals of `shape`."""
        since, until = self.change.since_range, self.change.until_range
        if self.change.name == "payload":
            return {"t0": since}
        return {"t0": since, "length": (max(until[0] - since[1], 0.0), until[1] - since[0])}


@dataclass(frozen=True)
class Unexplained:
    """Something is left that no known effect fits.

    Attributes:
        joint: its name.  coordinate: what it depends on, in words.
        share: root mean square of it over that of the joint's torque.
        gain: nats.
    """

    joint: str
    coordinate: str
    share: float
    gain: float


@dataclass(frozen=True)
class Diagnosis:
    """What is missing in a model.

    Attributes:
        model: that was diagnosed.
        motion: the search was made on.  unseen: it was confirmed on.
        separate: whether `unseen` is another recording, not the end of the same.
        search: all of the search.
        findings: effects, best first.  unexplained: dependences without a name.
        taken_up: a load taken up on the way, if there was one.
        not_observable: effects that this motion could not show.
    """

    model: Model
    motion: Motion
    unseen: Motion
    separate: bool
    search: Search
    findings: tuple[Finding, ...]
    unexplained: tuple[Unexplained, ...]
    taken_up: TakenUp | None
    not_observable: tuple[NotObservable, ...]

    @property
    def confirmed(self) -> tuple[Finding, ...]:
        """What may be added without asking."""
        return tuple(f for f in self.findings if f.verdict == CONFIRMED)

    def record(self) -> dict[str, object]:
        """For JSON; see `record`."""
        from lagrangian_ff.diagnosis.record import diagnosis_record

        return diagnosis_record(self)


def diagnose(
    model: Model,
    motion: Motion | Sequence[Motion],
    confirm: Motion | Sequence[Motion] = (),
    effects: Mapping[str, Effect] | None = None,
    steps: int = MOST_STEPS,
    progress: Progress = silent,
) -> Diagnosis:
    """Find out which physical effects a model lacks.

    Args:
        model: the model.
        motion: measured; what is missing is looked for here.
        confirm: measured too, not used in the search; without it the last third of `motion`.
        effects: those that may be missing; None takes the whole catalogue.
        steps: at most so many effects are looked for.
        progress: told the share done.

    Raises:
        ModelError: a recording lacks a joint of the model.
        RecordingError: there is too little motion.
    """
    first = _of_model(model, motion)
    unseen = _of_model(model, confirm) if not isinstance(confirm, Sequence) or confirm else None
    separate = unseen is not None
    if unseen is None:
        cut = round((1.0 - HELD_BACK) * len(first))
        first, unseen = first.take(slice(0, cut)), first.take(slice(cut, len(first)))
    for one in (first, unseen):
        _require_long(one)
    sliding = sliding_of(model.kernel, len(model.joints))
    inputs = model.inputs_of(first)
    # Handed on and not kept: each ground holds a factor.
    found = search(
        tune(first, inputs, model.basis, part(progress, 0.0, 0.3), sliding),
        effects,
        steps,
        part(progress, 0.3, 0.85),
    )
    progress(0.9, "confirming on unseen motion")
    taken_up = _taken_up(found, unseen, model.joints, separate)
    findings = _confirmed(found, unseen, model, taken_up)
    progress(1.0, "diagnosing")
    return Diagnosis(
        model,
        first,
        unseen,
        separate,
        found,
        findings,
        tuple(_unexplained(step, found.ground, model.joints) for step in found.steps
              if not step.named),
        taken_up,
        not_observable(found, model.joints),
    )  # fmt: skip


def _of_model(model: Model, motion: Motion | Sequence[Motion]) -> Motion:
    motions = [motion] if isinstance(motion, Motion) else list(motion)
    for one in motions:
        model.require_joints(one.joints, one.source)
    return concatenate([kept(m.select(model.joints)) for m in motions])


def _require_long(motion: Motion) -> None:
    length = seconds(motion)
    if length < SHORTEST:
        raise RecordingError(
            f"{motion.source}: {length:.1f} s of motion to judge by, expected at least "
            f"{SHORTEST:g} s: not observable here; record half a minute or more in which every "
            "joint moves through its range at several speeds"
        )


def _taken_up(
    found: Search, motion: Motion, joints: Sequence[str], separate: bool
) -> TakenUp | None:
    """The load taken up on the first motion, and whether the unseen one takes one up as well."""
    if found.change is None:
        return None
    felt, _ = joints_of(found.ground)
    names = tuple(joints[n] for n in felt)
    if not separate:
        reason = "it happens once in a recording; a second one can confirm it"
        return TakenUp(found.change, names, None, SUGGESTED, reason)
    again = change_of(_unseen(found, motion, None).ground, beyond=AGAIN)
    reason = "" if again else "the unseen recording shows nothing of the kind"
    if again and again.name != found.change.name:
        reason = f"in the unseen recording it is a {again.name}"
    return TakenUp(found.change, names, again, SUGGESTED if reason else CONFIRMED, reason)


def _confirmed(
    found: Search, motion: Motion, model: Model, taken_up: TakenUp | None
) -> tuple[Finding, ...]:
    joints = model.joints
    frozen = _frozen(found)
    change = taken_up.again if taken_up else None
    views = _views(found, motion, change)
    free = {
        score.candidate.joint: score.gain
        for score in reversed(found.last)
        if not score.candidate.named
    }
    findings = []
    for number, step in enumerate(found.steps):
        if not step.named:
            continue
        candidate = step.score.candidate
        unseen, trial = views[number]
        mine = unseen.rival(step.score, number)
        others = [(mine, unseen.rival(score, number)) for score in step.rivals]
        left = tuple(
            score.candidate.source.name for score in rivals(step.score, step.rivals, others)
        )
        reason = trial.reason
        rest = free.get(candidate.joint, 0.0)
        rest += sum(
            other.score.gain
            for other in found.steps
            if not other.named and other.score.candidate.joint == candidate.joint
        )
        if not reason and rest > LARGE_REST * step.score.gain:
            reason = (
                f"something without a name on the same joint gains {rest:.0f} nats, this "
                f"{step.score.gain:.0f}"
            )
        if not reason and candidate.effect.absorbed and model.kernel.free:
            reason = (
                f"gravity of {model.kernel.name} may be any smooth function of the positions and "
                "has this torque already: the effect may be there, but the model does not lack it"
            )
        parameters, low, high = frozen[number]
        reason = reason or candidate.effect.objection(low, high)
        verdict = SUGGESTED if reason else AMBIGUOUS if left else CONFIRMED
        findings.append(
            Finding(
                step,
                joints[candidate.joint],
                joints[candidate.effect.cause(candidate.joint, candidate.shape)],
                parameters,
                low,
                high,
                trial,
                left,
                verdict,
                reason,
            )
        )
    order = {CONFIRMED: 0, AMBIGUOUS: 1, SUGGESTED: 2}
    findings.sort(key=lambda f: (order[f.verdict], -f.step.score.gain))
    return tuple(findings)


def _views(
    found: Search, motion: Motion, change: Change | None
) -> Mapping[int, tuple[Unseen, Trial]]:
    """How each named step does on the unseen motion, and the view of that motion it is seen in.

    First everything is frozen. Where an effect fails beside a smaller one that fails as well, it is
    tried again with the smaller one fitted anew: what is not there would be taken away at a size
    that it has not, and be laid at the door of the larger.
    """
    unseen = _unseen(found, motion, change)
    named = [number for number, step in enumerate(found.steps) if step.named]
    views = {number: (unseen, _trial(found, unseen, number)) for number in named}
    failed: dict[int, list[int]] = {}
    for number in sorted(named, key=lambda n: -found.steps[n].score.gain):
        if not views[number][1].holds:
            failed.setdefault(found.steps[number].score.candidate.joint, []).append(number)
    smaller = {number for on_joint in failed.values() for number in on_joint[1:]}
    if smaller:
        unseen = _unseen(found, motion, change, smaller)
        for number, *others in failed.values():
            if others:
                views[number] = (unseen, _trial(found, unseen, number))
    return views


def _trial(found: Search, unseen: Unseen, number: int) -> Trial:
    """How a step does, alone, or else with all that has the same cause on other joints."""
    candidate = found.steps[number].score.candidate
    alone = unseen.trial([(number, candidate.joint)])
    same = [
        (n, other.score.candidate.joint)
        for n, other in enumerate(found.steps)
        if other.named and other.score.candidate.cause == candidate.cause
    ]
    together = unseen.trial(same) if len(same) > 1 and not alone.holds else alone
    return together if together.holds else alone


def _unseen(
    found: Search, motion: Motion, change: Change | None, anew: Collection[int] = ()
) -> Unseen:
    """The unseen motion with everything found taken away, frozen.

    The model's own stays free, and so do the steps that are to be fitted anew.
    """
    model = Basis(found.ground.basis.terms[: found.own])
    parameters = (
        values[:0] if number in anew else values
        for number, (values, _, _) in enumerate(_frozen(found))
    )
    candidates = (step.score.candidate for step in found.steps)
    taken = list(zip(candidates, parameters, strict=True))
    return Unseen.lay(motion, found.ground, model, taken, change)


def _frozen(found: Search) -> list[tuple[Floats, Floats, Floats]]:
    """For each step its parameters with 90 % intervals, all that was found in the model."""
    ground = found.ground
    places = [place for _, place in ground.basis.slices()][found.own :]
    values = ground.system.coefficients
    deviation = np.sqrt(
        np.maximum(ground.system.amplitude * np.diag(ground.system.covariance), 0.0)
    )
    out = []
    waiting = iter(places)
    for step in found.steps:
        if not step.named:
            empty = np.zeros(0)
            out.append((empty, empty, empty))
            continue
        place = next(waiting)
        reach = 1.645 * np.sqrt(step.score.inflation) * deviation[place]
        out.append((values[place], values[place] - reach, values[place] + reach))
    return out


def _unexplained(step: Step, ground: Ground, joints: Sequence[str]) -> Unexplained:
    candidate = step.score.candidate
    dependence = candidate.source
    words = told(str(getattr(dependence, "coordinate", dependence.name)), joints)
    return Unexplained(
        joints[candidate.joint],
        words,
        step.score.size / float(ground.spread[candidate.joint]),
        step.score.gain,
    )
