"""The diagnosis: from a model and a recording to the physical effects that the model lacks."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from lagrangian_ff.arrays import Floats
from lagrangian_ff.diagnosis import thresholds
from lagrangian_ff.diagnosis.contacts import Contact, contacts_of
from lagrangian_ff.diagnosis.intervals import widened
from lagrangian_ff.diagnosis.misfit import misfit_of
from lagrangian_ff.diagnosis.partial_residual import partial_residual
from lagrangian_ff.diagnosis.results import (
    Change,
    Diagnosis,
    Doubt,
    Finding,
    HoldOut,
    Ranked,
    Reason,
    Remainder,
    TakenUp,
    Unexplained,
    sorted_findings,
)
from lagrangian_ff.diagnosis.search.bayes_factor import BayesFactor
from lagrangian_ff.diagnosis.search.candidates import at_end, searched_for
from lagrangian_ff.diagnosis.search.change import change_of, joints_of
from lagrangian_ff.diagnosis.search.forward import (
    MOST_STEPS,
    Search,
    Step,
    beside_others,
    not_observable,
    search,
)
from lagrangian_ff.diagnosis.search.hold_out import (
    HoldOutMotion,
    frozen,
    judge_hold_out,
    judge_lag,
    without,
)
from lagrangian_ff.diagnosis.search.lag import allowing, confirms, earlier
from lagrangian_ff.diagnosis.search.left_over import more_than_noise, with_left_over
from lagrangian_ff.diagnosis.search.nonparametric import curve_of, with_joint_names
from lagrangian_ff.diagnosis.search.significance import rivals
from lagrangian_ff.diagnosis.search.signs import unnatural
from lagrangian_ff.diagnosis.whitening import Whitened, fit_for, in_full, outweighed
from lagrangian_ff.effects import EFFECTS, Effect, look_alikes
from lagrangian_ff.errors import RecordingError
from lagrangian_ff.identification import Model, decimated
from lagrangian_ff.identification.basis import Basis, Term
from lagrangian_ff.identification.build import seconds
from lagrangian_ff.identification.records import Estimate
from lagrangian_ff.progress import Progress, part, silent
from lagrangian_ff.recording.motion import WITHOUT_GRAVITY, Motion, concatenate


def diagnose(
    model: Model,
    motion: Motion | Sequence[Motion],
    confirm: Motion | Sequence[Motion] = (),
    effects: Mapping[str, Effect] | None = None,
    steps: int = MOST_STEPS,
    progress: Progress = silent,
    known: Sequence[Term] = (),
) -> Diagnosis:
    """Return the diagnosis of a model: the physical effects that it lacks.

    Args:
        motion: measured; the search uses it.
        confirm: measured; the hold-out uses it; without it the last third of `motion` serves.
        effects: those that may be missing; None takes the whole catalogue.
        steps: the largest number of effects to find.
        progress: receives the share done, 0 to 1.
        known: effects that other motion of the same arm confirmed. They are found again unless this
            motion speaks against them: where it hardly shows one, that takes nothing back.

    Raises:
        ModelError: a recording lacks a joint of the model.
        RecordingError: there is too little motion.
    """
    first, unseen, separate = searched_and_unseen(model, motion, confirm)
    fitting, searching = part(progress, 0.0, 0.3), part(progress, 0.3, 0.85)
    whitened = fit_for(model, first, Basis((*model.basis.terms, *known)), fitting)
    effects = effects or searched_for(model.data.effort, model.basis)
    read = model.identified.conditioning
    set_right = read is not None and read.effort_delay != 0.0
    if set_right:
        whitened = allowing(whitened)
    ended = search(whitened, effects, steps, searching, len(known), lagging=not set_right)
    in_step, lag = unseen, None
    if ended.lag is not None:
        searched, other = (earlier(one, ended.lag.delay) for one in (first, unseen))
        held = judge_lag(ended, other)
        if confirms(held):
            in_step, lag = other, replace(ended.lag, gained=float(held.gained.sum()))
            whitened = allowing(fit_for(model, searched, whitened.basis, fitting))
        ended = search(whitened, effects, steps, searching, len(known), lagging=False)
    del whitened  # it holds a factor of some 200 MB
    progress(0.85, "looking at what is left")
    weighed = ended.whitened.problem.samples.weight is not None
    found, again = _left_over(ended, in_step)
    del ended
    progress(0.9, "confirming on unseen motion")
    taken_up = _taken_up(found, in_step, model.joints, separate)
    lighter = outweighed(found.whitened) if weighed else None
    judged = replace(found, whitened=lighter or found.whitened)
    findings = findings_of(judged, in_step, model, taken_up.again if taken_up else None)
    del judged, lighter
    misfit = misfit_of(model, first)
    contacts = [] if misfit.larger else _contacts(model, motion, taken_up)
    curves = [found.steps[number] for number in sorted(again)]
    once = [s for n, s in enumerate(found.steps) if not s.named and n not in again]
    progress(1.0, "diagnosing")
    return Diagnosis(
        model=model,
        motion=first,
        held_out=unseen,
        separate=separate,
        findings=findings,
        unexplained=tuple(_unexplained(one, found.whitened, model.joints) for one in curves),
        taken_up=taken_up,
        not_observable=not_observable(found, model.joints),
        ranking=_ranking(found.ranking, found, model.joints),
        waiting=_ranking(found.last, found, model.joints),
        threshold=found.null.threshold,
        noise=found.whitened.noise,
        wanting=found.wanting,
        remainders=_remainders(found.whitened, once, model.joints),
        misfit=misfit,
        contacts=tuple(contacts),
        lag=lag,
    )


def _left_over(ended: Search, unseen: Motion) -> tuple[Search, frozenset[int]]:
    """Return what is left over, see `with_left_over`: of that, outliers are a part."""
    whole = replace(ended, whitened=in_full(ended.whitened))
    return with_left_over(whole, lambda: without(whole, unseen, None))


def searched_and_unseen(
    model: Model, motion: Motion | Sequence[Motion], confirm: Motion | Sequence[Motion] = ()
) -> tuple[Motion, Motion, bool]:
    """Return the motion to search, that to confirm on, and whether they are separate recordings.

    Args:
        motion, confirm: see `diagnose`, which says what is raised, too.
    """
    first = _of_model(model, motion)
    unseen = _of_model(model, confirm) if not isinstance(confirm, Sequence) or confirm else None
    separate = unseen is not None
    if unseen is None:
        cut = round((1.0 - thresholds.USED.held_back) * len(first))
        first, unseen = first.take(slice(0, cut)), first.take(slice(cut, len(first)))
    for one in (first, unseen):
        if (length := seconds(one)) < thresholds.USED.shortest:
            raise RecordingError(
                f"{one.source}: {length:.1f} s of motion to judge by, expected at least "
                f"{thresholds.USED.shortest:g} s: not observable here; record half a minute or "
                "more in which every joint moves through its range at several speeds"
            )
    return first, unseen, separate


def _of_model(model: Model, motion: Motion | Sequence[Motion]) -> Motion:
    motions = [motion] if isinstance(motion, Motion) else list(motion)
    for one in motions:
        model.require_motion(one)
    return concatenate([decimated(m.select(model.joints)) for m in motions])


def _contacts(
    model: Model, motion: Motion | Sequence[Motion], taken_up: TakenUp | None
) -> list[Contact]:
    """Return the touches in each recording; what lasts longer was found already."""
    every = list(contacts_of(model, [motion] if isinstance(motion, Motion) else motion))
    if taken_up is None:
        return every
    begin, end = taken_up.change.since, taken_up.change.until
    return [one for one in every if not begin <= one.begin <= end]


def _taken_up(
    found: Search, motion: Motion, joints: Sequence[str], separate: bool
) -> TakenUp | None:
    """Return the load taken up on the first motion, judged on the hold-out motion."""
    if found.change is None:
        return None
    felt, _ = joints_of(found.whitened)
    again, doubt = None, None
    if not separate:
        words = "it happens once in a recording; a second one can confirm it"
        doubt = Doubt(Reason.ONCE, words)
    else:
        limit = thresholds.USED.change_again
        again = change_of(without(found, motion, None).whitened, beyond=limit)
        if again is None:
            doubt = Doubt(Reason.NOT_AGAIN, "the unseen recording shows nothing of the kind")
        elif again.lasts != found.change.lasts:
            words = f"in the unseen recording it is a {again.effect.name}"
            doubt = Doubt(Reason.OTHER_KIND, words)
    moments = _moments(found.change)
    return TakenUp(
        effect=found.change.effect,
        joints=tuple(joints[n] for n in felt),
        shape={name: one.value for name, one in moments.items()},
        parameters=moments,
        log_bayes_factor=found.change.log_bayes_factor,
        doubt=doubt,
        change=found.change,
        again=again,
    )


def _moments(change: Change) -> dict[str, Estimate]:
    """Return when a load was taken up, and for how long if it was put down again."""
    begin, end = change.since_range, change.until_range
    found = {"t0": Estimate(change.since, *begin, "s")}
    if not change.lasts:
        low, high = max(end[0] - begin[1], 0.0), end[1] - begin[0]
        found["length"] = Estimate(change.until - change.since, low, high, "s")
    return found


def findings_of(
    found: Search, motion: Motion, model: Model, change: Change | None
) -> tuple[Finding, ...]:
    """Return the findings of a search, each with its verdict, best first.

    What shows only where outliers count less, and not on unseen motion, is none: what a form that
    is not quite the true one leaves shows as well between them.

    Args:
        found, motion: the search and the hold-out motion.
        change: where the hold-out motion takes up a load, if the first one did.
    """
    views, parameters = judge_hold_out(found, motion, change), frozen(found)
    named = [number for number, step in enumerate(found.steps) if step.named]
    findings = [_finding(found, model, n, *views[n], parameters[n]) for n in named]
    pairs = zip(findings, named, strict=True)
    return sorted_findings([one for one, n in pairs if _may_be(one, found.steps[n])])


def _may_be(one: Finding, step: Step) -> bool:
    """Return whether a finding counts that was found late, or is known of other motion."""
    if step.stands and not one.stands and step.score.log_bf <= thresholds.USED.floor:
        return False
    if not step.late:
        return True
    doubt = one.hold_out.doubt
    return doubt is None or doubt.reason not in (Reason.NOT_HELD_OUT, Reason.OTHER_SIZE)


def _finding(
    found: Search,
    model: Model,
    number: int,
    motion: HoldOutMotion,
    hold_out: HoldOut,
    parameters: tuple[Floats, Floats, Floats],
) -> Finding:
    step = found.steps[number]
    candidate, (values, low, high) = step.score.candidate, parameters
    half = widened(values, high - values, hold_out.gained, hold_out.expected)
    low, high = values - half, values + half
    effect, joint = candidate.effect, candidate.joint
    mine = motion.rival(step.score, number, candidate)
    others = [(mine, motion.rival(score, number, candidate)) for score in step.rivals]
    left = [one.candidate.source.name for one in rivals(step.score, step.rivals, others)]
    if found.whitened.motion.effort == WITHOUT_GRAVITY:
        left += [name for name in of_unseen_load(effect) if name not in left]
    alike = [one.candidate.source.name for one in step.rivals]
    other_size = hold_out.doubt is not None and hold_out.doubt.reason is Reason.OTHER_SIZE
    stands = step.stands and not left and not other_size
    return Finding(
        effect=effect,
        joints=tuple(model.joints[n] for n in (joint, *candidate.others)),
        cause=model.joints[effect.cause(joint, candidate.shape)],
        shape=effect.transferable(candidate.shape),
        parameters={
            one.name: Estimate(float(value), float(low), float(high), one.unit)
            for one, value, low, high in zip(effect.parameters, values, low, high, strict=True)
        },
        log_bayes_factor=step.score.log_bf,
        p_value=step.p_value,
        size=step.score.size,
        hold_out=hold_out,
        rivals=tuple(left),
        ruled_out=tuple(name for name in alike if name not in left),
        doubt=None if stands else hold_out.doubt or doubt_of(found, step, model),
        stands=stands,
        partial_residual=partial_residual(found.whitened, candidate, values),
    )


def of_unseen_load(effect: Effect) -> list[str]:
    """Return the look-alikes of friction over position that follow a load without its gravity.

    A gear carries the arm's weight, which depends on the position, even if the effort lacks it.
    """
    if effect.kind != "friction" or effect.coordinate != "position":
        return []
    return [name for name in look_alikes(effect) if "load" in EFFECTS[name].uses]


def doubt_of(found: Search, step: Step, model: Model) -> Doubt | None:
    """Return why an effect that holds on other motion is only suggested; None if it is not.

    Args:
        step: the step of the search that found the effect.
    """
    candidate = step.score.candidate
    if doubt := _of_large_rest(found, step):
        return doubt
    if candidate.effect.absorbed and model.kernel.free:
        words = (
            f"gravity of {model.kernel.name} may be any smooth function of the positions and "
            "has this torque already: the effect may be there, but the model does not lack it"
        )
        return Doubt(Reason.ABSORBED, words)
    if ends := at_end(found.whitened.x, candidate):
        return Doubt(Reason.AT_END, ends)
    objection = unnatural(found.whitened, step.score)
    return Doubt(Reason.IMPOSSIBLE, objection) if objection else None


def _of_large_rest(found: Search, step: Step) -> Doubt | None:
    """Return the doubt that curves on the joint explain nearly as much as an effect; None if not.

    Early steps score low, since what is found later is still noise. So where curves seem large by
    the scores of their steps, all are scored again with the noise that is left in the end.
    """
    share, joint = thresholds.USED.large_rest, step.score.candidate.joint
    scores = (s for s in found.last if not s.candidate.named and s.candidate.joint == joint)
    left = max((score.log_bf for score in scores), default=0.0)
    curves = [s for s in found.steps if not s.named and s.score.candidate.joint == joint]
    own = step.score.log_bf
    rest = left + sum(one.score.log_bf for one in curves)
    if rest > share * own and curves:
        own = beside_others(found, step)
        rest = left + sum(beside_others(found, one) for one in curves)
    if rest <= share * own:
        return None
    return Doubt(
        Reason.LARGE_REST,
        f"a torque that no effect of the catalogue describes gains {rest:.0f} nats on the same "
        f"joint, this effect {own:.0f}",
    )


def _unexplained(step: Step, whitened: Whitened, joints: Sequence[str]) -> Unexplained:
    candidate = step.score.candidate
    words = with_joint_names(candidate.source.coordinate, joints)
    share = step.score.size / float(whitened.spread[candidate.joint])
    assert not isinstance(candidate.source, Effect)
    curve = curve_of(candidate.source, candidate.joint, joints)
    return Unexplained(joints[candidate.joint], words, share, step.score.log_bf, curve)


def _remainders(
    whitened: Whitened, once: Sequence[Step], joints: Sequence[str]
) -> tuple[Remainder, ...]:
    """Return what is left and is more than noise, with the curves that did not come again.

    Of a curve only that counts which the model's own effects cannot stand in for.
    """
    squares = more_than_noise(whitened) ** 2
    for step in once:
        squares[step.score.candidate.joint] += (step.score.size * step.score.survival) ** 2
    every = zip(joints, np.sqrt(squares).tolist(), whitened.spread.tolist(), strict=True)
    return tuple(Remainder(name, size, size / spread) for name, size, spread in every if size > 0.0)


def _ranking(
    scores: Sequence[BayesFactor], found: Search, joints: Sequence[str]
) -> tuple[Ranked, ...]:
    ranked = []
    for score in scores:
        candidate, stands_out = score.candidate, found.null.exceeded_by(score.log_bf)
        name, joint = with_joint_names(candidate.source.name, joints), joints[candidate.joint]
        ranked.append(Ranked(name, joint, score.log_bf, candidate.named, stands_out))
    return tuple(ranked)
