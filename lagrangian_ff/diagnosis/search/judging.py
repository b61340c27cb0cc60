"""Judge the candidates of one joint, with the noise that is left once the best is explained."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from lagrangian_ff.diagnosis import thresholds
from lagrangian_ff.diagnosis.search.bayes_factor import (
    BayesFactor,
    bayes_factors,
    log_bayes_factor_of,
    refined,
)
from lagrangian_ff.diagnosis.search.candidates import (
    Candidate,
    at_end,
    named,
    nonparametric,
    not_held,
)
from lagrangian_ff.diagnosis.search.nonparametric import sinusoids
from lagrangian_ff.diagnosis.search.significance import MaximumNull, best_of_each, rivals
from lagrangian_ff.diagnosis.search.signs import natural
from lagrangian_ff.diagnosis.whitening import Whitened, refit
from lagrangian_ff.effects import Effect, Inputs
from lagrangian_ff.identification.basis import Basis
from lagrangian_ff.identification.problem import Nuisance, Problem
from lagrangian_ff.kernels import threads

SURE = 5.0
"""Times the floor above which hyperparameters that suit the motion without an effect are not sought
to do without it."""
NEAREST = 4
"""Effects whose shapes are refined where a step is judged again."""
REFINED = 8
"""Effects whose shapes are refined, besides plain friction."""


@dataclass(frozen=True)
class Step:
    """Something that was missing.

    Attributes:
        score: the best candidate, judged after the hyperparameters were refitted with it; its log
            Bayes factor compares it with the best model without it.
        rivals: effects that explain the data as well.
        first_log_bf: its log Bayes factor before the refit.
        p_value: how often the null reaches that, over all candidates.
        free: the best nonparametric alternative on the same joint, if any helped.
        late: whether it was found only once outliers counted less.
        stands: whether other motion confirmed it: it stays unless the evidence is against it.
    """

    score: BayesFactor
    rivals: tuple[BayesFactor, ...]
    first_log_bf: float
    p_value: float
    free: BayesFactor | None
    late: bool = False
    stands: bool = False

    @property
    def named(self) -> bool:
        """Return whether an effect of the catalogue explains it."""
        return self.score.candidate.named


def causes_of(basis: Basis) -> frozenset[tuple[str, int]]:
    """Return the causes that a basis explains, as `Candidate.cause`."""
    return frozenset((t.effect.name, t.effect.cause(t.joint, t.shape)) for t in basis.terms)


def candidates_of(
    whitened: Whitened, joints: Sequence[int] | range, effects: Mapping[str, Effect] | None
) -> list[Candidate]:
    """Return all candidates on some joints: effects, curves and sinusoids.

    What a curve of the model has is none.
    """
    x = whitened.x
    residual = whitened.motion.tau - whitened.inputs.torque
    waves = enumerate(sinusoids(whitened.motion.time, residual))
    every = [
        *named(x, whitened.basis, joints, effects),
        *nonparametric(x, joints),
        *(Candidate(wave, joint) for joint, wave in waves if joint in joints),
    ]
    return not_held(every, x, whitened.basis)


def possible(score: BayesFactor, causes: frozenset[tuple[str, int]], x: Inputs) -> bool:
    """Return whether hardware could do this.

    What the hardware of another joint causes must have been found on that joint first.
    """
    candidate = score.candidate
    if not candidate.named:
        return True
    if candidate.cause == candidate.key:
        return candidate.effect.possible(score.coefficients) and natural(score, x)
    return candidate.cause in causes


def judge(
    whitened: Whitened,
    first: BayesFactor,
    best: Sequence[BayesFactor],
    null: MaximumNull,
    effects: Mapping[str, Effect] | None,
) -> tuple[Step | None, Whitened]:
    """Return the step on one joint, judged after a refit, and the motion whitened for it.

    The best effect and the best curve are each judged with the noise that suits them: with the
    noise of the other they would look worse than they are. A curve that gains much more than the
    effect takes its place, unless the effect leaves nothing of it: then both are the same, and what
    is left only counts as fewer independent blocks beside the one than beside the other.

    Args:
        whitened: the motion, as it was searched.
        first: the best candidate of the joint; or of all.  best: every candidate at its best shape.
        null: of the maximum, for the p-value.
        effects: that may be missing; None takes the catalogue.
    """
    limits = thresholds.USED
    joint = first.candidate.joint
    here = [score for score in best if score.candidate.joint == joint and score.log_bf > 0.0]
    name = next((score for score in (first, *here) if score.candidate.named), None)
    free = next((score for score in (first, *here) if not score.candidate.named), None)
    both = [score for score in (name, free) if score is not None]
    near = limits.near * first.log_bf
    leaders = [score for score in both if score is first or score.log_bf > near]
    explained = [explained_with(whitened, one.candidate) for one in leaders]
    problems = threads.side_by_side(lambda one: refit(whitened, *one), explained)
    # One factor at a time: that of the effect, which mostly wins, is made last.
    views: list[_View] = []
    for leader, problem in reversed(list(zip(leaders, problems, strict=True))):
        refitted = None
        view, refitted = _View.of(whitened, leader, problem, effects)
        views.insert(0, view)
    named_view = max(views, key=lambda view: view.total(view.name), default=None)
    free_view = max(views, key=lambda view: view.total(view.free), default=None)
    if named_view is None or free_view is None or refitted is None:
        return None, whitened
    chosen, curve = named_view.name, free_view.free
    start = max(view.base for view in views if view.leader is first)
    named_log_bf, free_log_bf = named_view.total(chosen) - start, free_view.total(curve) - start
    plain = chosen is not None and chosen.candidate.effect.plain
    share = limits.first_share if plain and bare(whitened, joint) else limits.name_share
    least = share * free_log_bf
    if chosen is not None and (curve is None or named_log_bf > min(least, limits.floor)):
        found, view = chosen, named_view
    elif curve is not None:
        found, view = curve, free_view
    else:
        return None, whitened
    if view is not views[0]:
        refitted = None
        refitted = whitened.assuming(view.problem)
    displaced = found is chosen and named_log_bf <= least
    if curve is not None and displaced and _leaves_a_curve(refitted, found.candidate):
        found = curve
        if view is not free_view:
            refitted = None
            refitted = whitened.assuming(free_view.problem)
    without = max(whitened.system.log_evidence, *(view.base for view in views))
    log_bf = min(found.log_bf, log_bayes_factor_of(found, refitted, without))
    if limits.floor < log_bf < SURE * limits.floor:
        without = max(without, evidence_without(whitened))
        log_bf = min(log_bf, log_bayes_factor_of(found, refitted, without))
    if log_bf <= limits.floor:
        return None, whitened
    left = rivals(found, named_view.others) if found.candidate.named else ()
    p_value = null.p_value(first.log_bf)
    step = Step(replace(found, log_bf=log_bf), tuple(left), first.log_bf, p_value, curve)
    return step, refitted


def _leaves_a_curve(whitened: Whitened, effect: Candidate) -> bool:
    """Return whether a curve on the joint still gains something beside an effect."""
    beside = whitened.explaining(*explained_with(whitened, effect))
    curves = [one for one in candidates_of(beside, [effect.joint], None) if not one.named]
    left = bayes_factors(beside, curves)
    beside.forget()
    return any(score.log_bf > 0.0 for score in left)


def evidence_without(whitened: Whitened) -> float:
    """Return the log evidence with the hyperparameters that suit the motion as it is explained."""
    problem = refit(whitened, whitened.basis, whitened.problem.nuisance)
    return whitened.assuming(problem).system.log_evidence


def judge_alike(
    whitened: Whitened,
    step: Step,
    strong: Sequence[BayesFactor],
    null: MaximumNull,
    effects: Mapping[str, Effect] | None,
) -> tuple[list[Step], Whitened]:
    """Return the steps of the same effect on other joints, and the motion with them explained.

    Gears are of one make: what one of them has, most have. Each joint is judged by itself, with the
    hyperparameters at hand, which are refitted once for all.

    Args:
        whitened: the motion with the step explained.
        step: just found.  strong: the candidates that stood out before it.
        null, effects: see `judge`.
    """
    name = step.score.candidate.source.name
    found = []
    for first in strong:
        joint = first.candidate.joint
        if first.candidate.source.name != name or joint == step.score.candidate.joint:
            continue
        best = _best_here(whitened, joint, effects)
        names = [one for one in best if one.candidate.named]
        free = next((one for one in best if not one.candidate.named), None)
        if not names or names[0].candidate.source.name != name:
            continue
        score = refined(whitened, names[0])
        whitened.forget()
        least = thresholds.USED.name_share * free.log_bf if free else 0.0
        if score.log_bf > max(least, thresholds.USED.floor):
            p_value, left = null.p_value(first.log_bf), tuple(rivals(score, names[1:]))
            found.append(Step(score, left, first.log_bf, p_value, free))
            whitened = whitened.explaining(*explained_with(whitened, score.candidate))
    if found:
        whitened = whitened.assuming(refit(whitened, whitened.basis, whitened.problem.nuisance))
    return found, whitened


def reconsider(
    less: Whitened, step: Step, effects: Mapping[str, Effect] | None
) -> tuple[Step, Whitened]:
    """Return a step judged again beside what was found after it, and the motion with it explained.

    The first effect that is found has to do for others, too: its form and its rivals are those of
    all of them together. Another effect takes its place if that rules it out now. What other motion
    confirmed is not reopened by what is too faint here to be claimed.

    Args:
        less: the motion with all steps but this one explained.
    """
    candidate = step.score.candidate
    best = [one for one in _best_here(less, candidate.joint, effects) if one.candidate.named]
    names = [refined(less, one) for one in best[:NEAREST]]
    (mine,) = bayes_factors(less, [candidate])
    less.forget()
    mine = max([mine, *(one for one in names if one.candidate.key == candidate.key)], key=_log_bf)
    first = possible_first(sorted([mine, *names], key=_log_bf, reverse=True), less.x)[0]
    if step.stands and first.log_bf <= thresholds.USED.floor:
        first = mine
    if first is not mine and not rivals(first, [mine]):
        step = replace(step, score=first, rivals=tuple(rivals(first, names)), stands=False)
    elif first is not mine or step.rivals:
        step = replace(step, rivals=tuple(rivals(mine, names)))
    return step, less.explaining(*explained_with(less, step.score.candidate))


def _log_bf(score: BayesFactor) -> float:
    return score.log_bf


def _best_here(
    whitened: Whitened, joint: int, effects: Mapping[str, Effect] | None
) -> list[BayesFactor]:
    """Return the candidates that may be on one joint, each at its best shape, best first."""
    causes = causes_of(whitened.basis)
    scores = bayes_factors(whitened, candidates_of(whitened, [joint], effects))
    best = best_of_each(scores, causes)
    return [one for one in best if one.log_bf > 0.0 and possible(one, causes, whitened.x)]


@dataclass(frozen=True)
class _View:
    """One joint with the hyperparameters that suit one candidate.

    Attributes:
        leader: that candidate.  problem: with these hyperparameters.
        base: log evidence of the problem without the candidate.
        name, others: the best effect at its best shape, and the other effects.
        free: the best curve.
    """

    leader: BayesFactor
    problem: Problem
    base: float
    name: BayesFactor | None
    others: tuple[BayesFactor, ...]
    free: BayesFactor | None

    @classmethod
    def of(
        cls,
        whitened: Whitened,
        leader: BayesFactor,
        problem: Problem,
        effects: Mapping[str, Effect] | None,
    ) -> tuple["_View", Whitened]:
        """Return the view, and the motion whitened for it."""
        joint = leader.candidate.joint
        refitted = whitened.assuming(problem)
        found = _best_here(refitted, joint, effects)
        # An event as leader was not compared with the null: only events may take its place.
        best = [one for one in found if one.candidate.named and (one.once or not leader.once)]
        best = [
            refined(refitted, one)
            for number, one in enumerate(best)
            if number < REFINED or one.candidate.effect.plain
        ]
        ranked = sorted(best, key=lambda one: -_penalised(refitted, one))
        names = _plain_first(possible_first(ranked, refitted.x), bare(refitted, joint))
        free = next((one for one in found if not one.candidate.named), None)
        refitted.forget()
        base = refitted.system.log_evidence
        name = names[0] if names else None
        return cls(leader, problem, base, name, tuple(names[1:]), free), refitted

    def total(self, score: BayesFactor | None) -> float:
        """Return the log evidence with a candidate, which can be compared between views."""
        return -np.inf if score is None else self.base + score.log_bf


def bare(whitened: Whitened, joint: int) -> bool:
    """Return whether the model has no friction on a joint."""
    return not any(term.effect.plain for term in whitened.basis.terms if term.joint == joint)


def possible_first(names: list[BayesFactor], x: Inputs) -> list[BayesFactor]:
    """Return the effects, best first, but one that may be before all whose shape is at an end.

    These ask for what they cannot be. Often two effects are missing, of which such a shape imitates
    a part each.
    """
    share = thresholds.USED.possible_share
    for score in names:
        if not at_end(x, score.candidate) and score.log_bf > share * names[0].log_bf:
            return [score, *(one for one in names if one is not score)]
    return names


def _plain_first(names: list[BayesFactor], bare_joint: bool) -> list[BayesFactor]:
    """Return the effects, plain friction first if it explains a large share of what the best does.

    Where plain friction is missing altogether, one curve with a bend does better than Coulomb's or
    viscous friction alone. The plain ones come first, one after the other; the bend follows only if
    it is still needed.
    """
    share = thresholds.USED.first_share if bare_joint else thresholds.USED.plain_share
    for score in names:
        if score.candidate.effect.plain and score.log_bf > share * names[0].log_bf:
            return [score, *(one for one in names if not _over_velocity(one.candidate.effect))]
    return names


def _over_velocity(effect: Effect) -> bool:
    """Return whether an effect may pass for plain friction where that is missing."""
    return effect.kind == "friction" or effect.coordinate == "velocity"


def _penalised(whitened: Whitened, score: BayesFactor) -> float:
    """Return the log Bayes factor less the log of the number of shapes tried."""
    shapes = score.candidate.effect.candidates(whitened.x, score.candidate.joint)
    return score.log_bf - float(np.log(max(len(shapes), 1)))


def explained_with(whitened: Whitened, candidate: Candidate) -> tuple[Basis, tuple[Nuisance, ...]]:
    """Return the basis and the nuisance columns with a candidate added."""
    if candidate.named:
        return Basis((*whitened.basis.terms, candidate.term())), whitened.problem.nuisance
    columns = candidate.columns(whitened.x)
    return whitened.basis, (*whitened.problem.nuisance, Nuisance(candidate.joint, columns))
