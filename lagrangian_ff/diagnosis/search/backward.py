"""The steps of a search, each judged again beside all others."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from lagrangian_ff.diagnosis import thresholds
from lagrangian_ff.diagnosis.search.bayes_factor import bayes_factors, refined
from lagrangian_ff.diagnosis.search.candidates import Candidate, bends_over_speed
from lagrangian_ff.diagnosis.search.judging import Step, reconsider
from lagrangian_ff.diagnosis.search.significance import MaximumNull
from lagrangian_ff.diagnosis.whitening import Whitened
from lagrangian_ff.diagnosis.whitening.hyperparameters import with_sign_speeds
from lagrangian_ff.effects import Effect
from lagrangian_ff.identification.basis import Basis


def judged_again(
    whitened: Whitened, own: int, null: MaximumNull, effects: Mapping[str, Effect] | None
) -> tuple[list[Step], Whitened]:
    """Return a step for each effect known of other motion, and the motion with them explained.

    Of motion in which its joint is held, little is to be seen of an effect: that takes nothing
    back. Those that the evidence is against are left out; one that another rules out is replaced.

    Args:
        whitened: the motion with the known effects explained.
        own: the number of the model's own terms, which come first.
        null: of the maximum over all other candidates.  effects: see `search`.
    """
    taken: list[Step] = []
    for term in whitened.basis.terms[own:]:
        candidate = Candidate(term.effect, term.joint, term.shape)
        less = _less(whitened, own, candidate)
        bends = bends_over_speed(term.effect)
        if bends:  # the width of the step was fitted beside it, and makes it seem needed
            less = with_sign_speeds(less, {term.joint})
        shapes = term.effect.candidates(less.x, term.joint)
        tried = [candidate, *(replace(candidate, shape=shape) for shape in shapes)]
        score = refined(less, max(bayes_factors(less, tried), key=lambda one: one.log_bf))
        step = Step(score, (), score.log_bf, null.p_value(score.log_bf), None, stands=True)
        step, more = reconsider(less, step, effects)
        if step.score.log_bf <= (0.0 if step.stands else thresholds.USED.floor):
            whitened = less
            continue
        taken.append(step)
        whitened = with_sign_speeds(more, {term.joint}) if bends else more
    return taken, whitened


def backward(
    taken: list[Step], whitened: Whitened, own: int, kept: int = 0
) -> tuple[list[Step], Whitened]:
    """Return the steps without those that later ones made superfluous, and the motion with them.

    Args:
        kept: the number of steps, from the first on, that stay.
    """
    while sum(step.named for step in taken) > 1:
        needed: list[Needed] = []
        for number, step in enumerate(taken):
            if step.named:
                less = _less(whitened, own, step.score.candidate)
                (score,) = bayes_factors(less, [step.score.candidate])
                needed.append(Needed(number, score.candidate.joint, score.log_bf, step.stands))
        last = superfluous(needed, kept)
        if last is None:
            break
        whitened = _less(whitened, own, taken[last].score.candidate)
        taken = taken[:last] + taken[last + 1 :]
    return taken, whitened


def reconsidered(
    taken: list[Step],
    whitened: Whitened,
    own: int,
    effects: Mapping[str, Effect] | None,
    kept: int = 0,
) -> tuple[list[Step], Whitened]:
    """Return the steps, each judged again beside all others, and the motion with them.

    Args:
        kept: the number of steps, from the first on, that stay.
    """
    if len(taken) < 2:
        return taken, whitened
    for number, step in enumerate(taken):
        if number < kept or not step.named:
            continue
        if not step.score.candidate.effect.plain and not step.score.once:
            less = _less(whitened, own, step.score.candidate)
            found, whitened = reconsider(less, step, effects)
            taken[number] = replace(found, late=step.late)
    terms = [step.score.candidate.term() for step in taken if step.named]
    basis = Basis((*whitened.basis.terms[:own], *terms))  # in the order of the steps
    return taken, whitened.explaining(basis, whitened.problem.nuisance)


def _less(whitened: Whitened, own: int, one: Candidate) -> Whitened:
    """Return the motion with all explained but one candidate."""
    basis = basis_without(whitened.basis, own, one)
    return whitened.explaining(basis, whitened.problem.nuisance)


class Needed(NamedTuple):
    """The log Bayes factor of a step beside all others, in nats, its joint, and `Step.stands`."""

    number: int
    joint: int
    log_bf: float
    stands: bool = False


def superfluous(needed: Sequence[Needed], kept: int = 0) -> int | None:
    """Return the number of the step needed least, if it is needed too little; else None.

    A step is needed too little below the floor, or if it gains little beside another effect on the
    same joint: a slightly wrong form of that effect leaves as much. What other motion confirmed is
    needed unless the evidence is against it.

    Args:
        kept: the number of steps, from the first on, that stay.
    """

    def share(one: Needed) -> float:
        if one.stands:
            return np.inf if one.log_bf > 0.0 else 0.0
        largest = max(other.log_bf for other in needed if other.joint == one.joint)
        return one.log_bf / max(thresholds.USED.floor, thresholds.USED.remainder * largest)

    least = min((one for one in needed if one.number >= kept), key=share, default=None)
    return least.number if least is not None and share(least) <= 1.0 else None


def basis_without(basis: Basis, own: int, one: Candidate) -> Basis:
    """Return the basis without a candidate; the model's own terms come first in it."""
    found = [term for term in basis.terms[own:] if (term.effect.name, term.joint) != one.key]
    return Basis((*basis.terms[:own], *found))
