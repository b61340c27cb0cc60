"""Forward search: find the best candidate, explain it, refit, look again; then backward.

The same Bayes factors show which effects the motion could not have shown.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from lagrangian_ff.diagnosis import thresholds
from lagrangian_ff.diagnosis.results import Change, NotObservable
from lagrangian_ff.diagnosis.search.bayes_factor import PRIOR_SHARE, BayesFactor, bayes_factors
from lagrangian_ff.diagnosis.search.change import change_of
from lagrangian_ff.diagnosis.search.judging import (
    Step,
    bare,
    candidates_of,
    causes_of,
    explained_with,
    judge,
    possible,
)
from lagrangian_ff.diagnosis.search.significance import MaximumNull, best_of_each
from lagrangian_ff.diagnosis.whitening import Whitened, refit
from lagrangian_ff.effects import EFFECTS, Effect
from lagrangian_ff.identification.basis import Basis
from lagrangian_ff.progress import Progress, silent

MOST_STEPS = 6


@dataclass(frozen=True)
class Search:
    """The search on one whitened motion.

    Attributes:
        steps: what was found, in order.
        all: all candidates at all shapes, scored before the first step.
        ranking: of these, each candidate at its best shape, best first.
        last: the same after the last step, when nothing stood out any more.
        null: of the maximum, before the first step.
        change: a load that was taken up on the way, if any.
        whitened: the motion, with all steps explained.
        own: the number of terms that the basis had before the first step.
    """

    steps: tuple[Step, ...]
    all: tuple[BayesFactor, ...]
    ranking: tuple[BayesFactor, ...]
    last: tuple[BayesFactor, ...]
    null: MaximumNull
    change: Change | None
    whitened: Whitened
    own: int


def search(
    whitened: Whitened,
    effects: Mapping[str, Effect] | None = None,
    steps: int = MOST_STEPS,
    progress: Progress = silent,
) -> Search:
    """Return the search, which takes one step after the other until nothing stands out.

    Args:
        whitened: the motion, with the model's effects.
        effects: those that may be missing; None takes the catalogue.
        steps: the largest number of steps.
        progress: receives the share done, 0 to 1.
    """
    own = len(whitened.basis.terms)
    taken: list[Step] = []
    change: Change | None = None
    may_change = any(one.arm_event == "lasting" for one in (effects or EFFECTS).values())
    rounds: list[tuple[list[BayesFactor], list[BayesFactor], MaximumNull]] = []
    while True:
        share = len(taken) / (steps + 1)
        progress(share, f"looking at every effect, step {len(taken) + 1}")
        candidates = candidates_of(whitened, range(whitened.joints), effects)
        found = bayes_factors(whitened, candidates, coarse=True)
        whitened.forget()
        causes = causes_of(whitened.basis)
        best = best_of_each(found, causes)
        null = MaximumNull.of([score for score in found if not score.once])
        rounds.append((found, best, null))
        strong = [score for score in best if _stands_out(score, null, whitened)]
        eligible = [score for score in strong if possible(score, causes)]
        if change is None and may_change and (not taken or not eligible):
            change = change_of(whitened)
            if change is not None and change.log_bayes_factor > _to_beat(whitened, eligible):
                nuisance = whitened.problem.nuisance
                problem = refit(whitened, whitened.basis, nuisance, change.prior)
                whitened = whitened.assuming(problem)
                continue
            change = None
        if not eligible or len(taken) == steps:
            break
        name = eligible[0].candidate.source.name
        progress(share + 0.5 / (steps + 1), f"looking closer at {name}")
        step, refitted = judge(whitened, eligible[0], best, null, effects)
        if step is None:
            break
        taken.append(step)
        whitened = refitted.explaining(*explained_with(whitened, step.score.candidate))
    taken, whitened = _backward(taken, whitened, own)
    (every, ranking, null), (_, last, _) = rounds[0], rounds[-1]
    return Search(
        tuple(taken), tuple(every), tuple(ranking), tuple(last), null, change, whitened, own
    )


def _backward(taken: list[Step], whitened: Whitened, own: int) -> tuple[list[Step], Whitened]:
    """Return the steps without those that later ones made superfluous, and the motion with them."""
    while sum(step.named for step in taken) > 1:
        needed: list[Needed] = []
        for number, step in enumerate(taken):
            if step.named:
                basis = _without(whitened.basis, own, step)
                less = whitened.explaining(basis, whitened.problem.nuisance)
                (score,) = bayes_factors(less, [step.score.candidate])
                needed.append(Needed(number, score.candidate.joint, score.log_bf))
        last = superfluous(needed)
        if last is None:
            break
        basis = _without(whitened.basis, own, taken[last])
        taken = taken[:last] + taken[last + 1 :]
        whitened = whitened.explaining(basis, whitened.problem.nuisance)
    return taken, whitened


class Needed(NamedTuple):
    """The log Bayes factor of a step beside all others, in nats, and its joint."""

    number: int
    joint: int
    log_bf: float


def superfluous(needed: Sequence[Needed]) -> int | None:
    """Return the number of the step needed least, if it is needed too little; else None.

    A step is needed too little below the floor, or if it gains little beside another effect on the
    same joint: a slightly wrong form of that effect leaves as much.
    """

    def share(one: Needed) -> float:
        largest = max(other.log_bf for other in needed if other.joint == one.joint)
        return one.log_bf / max(thresholds.USED.floor, thresholds.USED.remainder * largest)

    least = min(needed, key=share)
    return least.number if share(least) <= 1.0 else None


def _without(basis: Basis, own: int, step: Step) -> Basis:
    """Return the basis without the term of a step; the model's own terms come first in it."""
    key = step.score.candidate.key
    found = [term for term in basis.terms[own:] if (term.effect.name, term.joint) != key]
    return Basis((*basis.terms[:own], *found))


def _stands_out(score: BayesFactor, null: MaximumNull, whitened: Whitened) -> bool:
    """Return whether a score is large enough to be claimed."""
    limits = thresholds.USED
    if score.size <= limits.least_size * whitened.spread[score.candidate.joint]:
        return False
    if score.once:
        return score.log_bf > limits.event_floor
    return score.log_bf > limits.floor and null.exceeded_by(score.log_bf)


def _to_beat(whitened: Whitened, eligible: Sequence[BayesFactor]) -> float:
    """Return the nats that a change of the whole arm must exceed to come before these scores.

    Where friction is missing altogether, a second Lagrangian takes up much of it.
    """
    without = any(bare(whitened, score.candidate.joint) for score in eligible)
    factor = thresholds.USED.bare_factor if without else 1.0
    return factor * max((score.log_bf for score in eligible), default=0.0)


def not_observable(found: Search, joints: Sequence[str]) -> tuple[NotObservable, ...]:
    """Return the effects, joint by joint, that this motion hides."""
    motion = found.whitened.motion
    still = np.ptp(motion.q, axis=0) < thresholds.USED.still
    power: dict[tuple[str, int], float] = {}
    present = {step.score.candidate.key for step in found.steps}
    for score in found.all:
        if score.candidate.named and score.candidate.key not in present:
            key = score.candidate.key
            power[key] = max(power.get(key, -np.inf), _expected_log_bf(score))
    missing = []
    for (name, joint), log_bf in power.items():
        effect = EFFECTS.get(name) or next(
            s.candidate.effect for s in found.all if s.candidate.key == (name, joint)
        )
        if still[joint]:
            reason = f"{joints[joint]} stands still"
        elif log_bf < thresholds.USED.floor:
            reason = (
                f"at {thresholds.USED.observable_size:.0%} of the joint's torque it would gain "
                f"{max(log_bf, 0.0):.1f} nats of evidence, {thresholds.USED.floor:g} are needed"
            )
        else:
            continue
        missing.append(NotObservable(name, joints[joint], reason, effect.next_motion))
    for name in sorted(name for name, effect in EFFECTS.items() if not effect.observable):
        effect = EFFECTS[name]
        missing.append(NotObservable(name, "all", effect.caution, effect.next_motion))
    return tuple(missing)


def _expected_log_bf(score: BayesFactor) -> float:
    """Return the mean log Bayes factor of the effect at `observable_size` of the joint's torque."""
    information = score.information / score.variance_inflation
    size = thresholds.USED.observable_size / PRIOR_SHARE
    signal = float(np.trace(information)) / len(information) * size**2
    price = float(np.linalg.slogdet(np.eye(len(information)) + information)[1])
    return 0.5 * (signal - price)
