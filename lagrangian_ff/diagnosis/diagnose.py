"""The diagnosis: from a model and a recording to the physical effects that the model lacks."""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace

import numpy as np

from lagrangian_ff.diagnosis import thresholds
from lagrangian_ff.diagnosis.confidence import Doubt, Reason
from lagrangian_ff.diagnosis.consequence import by_joint, errors_of
from lagrangian_ff.diagnosis.contacts import Contact, contacts_of
from lagrangian_ff.diagnosis.lag import Lag
from lagrangian_ff.diagnosis.misfit import misfit_of
from lagrangian_ff.diagnosis.results import (
    Change,
    Diagnosis,
    Ranked,
    Remainder,
    TakenUp,
    Unexplained,
)
from lagrangian_ff.diagnosis.search.bayes_factor import BayesFactor
from lagrangian_ff.diagnosis.search.candidates import searched_for
from lagrangian_ff.diagnosis.search.change import change_of, joints_of
from lagrangian_ff.diagnosis.search.forward import MOST_STEPS, Search, Step, not_observable, search
from lagrangian_ff.diagnosis.search.hold_out import judge_lag, without
from lagrangian_ff.diagnosis.search.lag import allowing, confirms, earlier
from lagrangian_ff.diagnosis.search.left_over import (
    more_than_noise,
    torque_of_curves,
    with_left_over,
)
from lagrangian_ff.diagnosis.search.nonparametric import curve_of, with_joint_names
from lagrangian_ff.diagnosis.verdicts import findings_of
from lagrangian_ff.diagnosis.whitening import Whitened, fit_for, in_full, outweighed
from lagrangian_ff.effects import Effect
from lagrangian_ff.errors import RecordingError
from lagrangian_ff.identification import Model, decimated
from lagrangian_ff.identification.basis import Basis, Term
from lagrangian_ff.identification.build import seconds
from lagrangian_ff.identification.records import Estimate
from lagrangian_ff.progress import Progress, part, silent
from lagrangian_ff.recording.motion import Motion, concatenate


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
    searching = part(progress, 0.0, 0.85)
    ended, in_step, lag = _searched(model, first, unseen, effects, steps, known, searching)
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
        remainders=_remainders(found, again, model.joints),
        missed=by_joint(model, errors_of(model, decimated(unseen))),
        misfit=misfit,
        contacts=tuple(contacts),
        lag=lag,
    )


def _searched(
    model: Model,
    first: Motion,
    unseen: Motion,
    effects: Mapping[str, Effect] | None,
    steps: int,
    known: Sequence[Term],
    progress: Progress,
) -> tuple[Search, Motion, Lag | None]:
    """Return the search, the unseen motion with its torques in step, and the lag that both show.

    Args:
        first, unseen: see `searched_and_unseen`; the others are those of `diagnose`.
    """
    fitting, searching = part(progress, 0.0, 0.35), part(progress, 0.35, 1.0)
    whitened = fit_for(model, first, Basis((*model.basis.terms, *known)), fitting)
    effects = effects or searched_for(model.data.effort, model.basis)
    read = model.identified.conditioning
    set_right = read is not None and read.effort_delay != 0.0
    if set_right:
        whitened = allowing(whitened)
    ended = search(whitened, effects, steps, searching, len(known), lagging=not set_right)
    if ended.lag is None:
        return ended, unseen, None
    searched, in_step = (earlier(one, ended.lag.delay) for one in (first, unseen))
    held = judge_lag(ended, in_step)
    lag = None
    if confirms(held):
        lag = replace(ended.lag, gained=float(held.gained.sum()))
        whitened = allowing(fit_for(model, searched, whitened.basis, fitting))
    ended = search(whitened, effects, steps, searching, len(known), lagging=False)
    return ended, unseen if lag is None else in_step, lag


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


def _unexplained(step: Step, whitened: Whitened, joints: Sequence[str]) -> Unexplained:
    candidate = step.score.candidate
    words = with_joint_names(candidate.source.coordinate, joints)
    share = step.score.size / float(whitened.spread[candidate.joint])
    assert not isinstance(candidate.source, Effect)
    curve = curve_of(candidate.source, candidate.joint, joints)
    return Unexplained(joints[candidate.joint], words, share, step.score.log_bf, curve)


def _remainders(
    found: Search, again: Collection[int], joints: Sequence[str]
) -> tuple[Remainder, ...]:
    """Return what is left and is more than noise, with the curves that did not come again."""
    once = [step for n, step in enumerate(found.steps) if not step.named and n not in again]
    left = np.hypot(more_than_noise(found.whitened), torque_of_curves(found, once))
    every = zip(joints, left.tolist(), found.whitened.spread.tolist(), strict=True)
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
