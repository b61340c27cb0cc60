"""One effect at a time: find the best, take it in, choose the noise anew, look again; then back."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from lagrangian_ff.diagnosis.ground import Ground, Prior, sharpen
from lagrangian_ff.diagnosis.ground.ground import Extra
from lagrangian_ff.diagnosis.search.candidates import Candidate, named, unnamed
from lagrangian_ff.diagnosis.search.chance import Chance
from lagrangian_ff.diagnosis.search.change import Change, change_of
from lagrangian_ff.diagnosis.search.gain import Score, scores
from lagrangian_ff.diagnosis.search.refine import refined
from lagrangian_ff.diagnosis.search.rivals import best_of_each, rivals
from lagrangian_ff.diagnosis.search.tones import tones
from lagrangian_ff.diagnosis.search.worth import evidence_without, worth_of
from lagrangian_ff.effects import Effect
from lagrangian_ff.identification.basis import Basis
from lagrangian_ff.kernels import threads
from lagrangian_ff.progress import Progress, silent

MOST_STEPS = 6
FLOOR = 20.0
"""Nats below which nothing is claimed, whatever chance says."""
EVENT_FLOOR = 25.0
"""The same for what happens once only: signs of blocks cannot tell it from an outlier."""
REMAINDER = 0.03
"""Of the gain of another effect on the joint, what may as well be a flaw of that one's form."""
LEAST_SIZE = 0.005
"""Share of a joint's torque below which an effect is not worth a name."""
NAME_SHARE = 0.7
"""A name must explain this share of what a free curve over one coordinate does."""
PLAIN, PLAIN_SHARE, FIRST_SHARE = ("coulomb", "viscous"), 0.6, 0.2
"""Friction that every joint has, and how much of what the best explains it must explain: where the
model has one of the two on the joint, and where it has none."""
BARE = 3.0
"""Times the gain of the best that a change of the arm must gain where plain friction is missing."""
NEAR = 0.2
"""A name or a curve is looked at closely if at first it gains this share of the best."""
REFINED = 8
"""Names whose shapes are refined, besides plain friction."""


@dataclass(frozen=True)
class Step:
    """Something that was missing.

    Attributes:
        score: the best candidate, judged once the noise was chosen with it in the model; its gain
            is what it is worth over the best without it.
        rivals: named candidates that the data cannot tell from it.
        first_gain: its gain before the noise was chosen anew.
        p_value: how often chance gains as much, over all candidates.
        free: the best dependence without a name on the same joint, if any gained.
    """

    score: Score
    rivals: tuple[Score, ...]
    first_gain: float
    p_value: float
    free: Score | None

    @property
    def named(self) -> bool:
        """Whether an effect of the catalogue explains it."""
        return self.score.candidate.named


@dataclass(frozen=True)
class Search:
    """The whole search on one ground.

    Attributes:
        steps: what was found, in order.
        all: the first look at all candidates, at all shapes.
        ranking: of the first look, each candidate at its best shape, best first.
        last: the same of the last look, when nothing stood out any more.
        chance: of the first look.
        change: a load that was taken up on the way, if any.
        ground: the last one, with all steps taken in.
        own: how many terms of its basis were there before any step.
    """

    steps: tuple[Step, ...]
    all: tuple[Score, ...]
    ranking: tuple[Score, ...]
    last: tuple[Score, ...]
    chance: Chance
    change: Change | None
    ground: Ground
    own: int


def search(
    ground: Ground,
    effects: Mapping[str, Effect] | None = None,
    steps: int = MOST_STEPS,
    progress: Progress = silent,
) -> Search:
    """Look for what is missing until nothing stands out.

    Args:
        ground: of the motion, with the model's effects.
        effects: those that may be missing; None takes the catalogue.
        steps: at most so many are found.
        progress: told the share done.
    """
    own = len(ground.basis.terms)
    taken: list[Step] = []
    change: Change | None = None
    may_change = effects is None or "payload" in effects
    looks: list[tuple[list[Score], list[Score], Chance]] = []
    while True:
        share = len(taken) / (steps + 1)
        progress(share, f"looking at every effect, step {len(taken) + 1}")
        candidates = _candidates(ground, range(ground.joints), effects)
        found = scores(ground, candidates, coarse=True)
        ground.forget()
        causes = _causes(ground.basis)
        lasting = [score for score in found if not score.once]
        looks.append((found, best_of_each(found, causes), Chance.of(lasting)))
        _, best, chance = looks[-1]
        eligible = [
            score
            for score in best
            if _stands_out(score, chance, ground) and _possible(score, causes)
        ]
        if change is None and may_change and (not taken or not eligible):
            change = change_of(ground)
            if change is not None and change.gain > _best_gain(ground, eligible):
                prior = replace(ground.prior, change=change.prior)
                prior = sharpen(ground, ground.basis, ground.extra, prior=prior)
                ground = ground.relaid(prior)
                continue
            change = None
        if not eligible or len(taken) == steps:
            break
        progress(
            share + 0.5 / (steps + 1), f"looking closer at {eligible[0].candidate.source.name}"
        )
        step, judged = _judge(ground, eligible[0], best, chance, effects)
        if step is None:
            break
        taken.append(step)
        basis, extra = _with(ground, step.score.candidate)
        ground = judged.relaid(basis=basis, extra=extra)
    taken, ground = _backward(taken, ground, own)
    every, ranking, chance = looks[0]
    return Search(
        tuple(taken), tuple(every), tuple(ranking), tuple(looks[-1][1]), chance, change, ground,
        own,
    )  # fmt: skip


def _backward(taken: list[Step], ground: Ground, own: int) -> tuple[list[Step], Ground]:
    """Take out again what the later ones made superfluous, the least needed first."""
    while sum(step.named for step in taken) > 1:
        needed: list[Needed] = []
        for number, step in enumerate(taken):
            if step.named:
                basis = _without(ground.basis, own, step)
                less = ground.relaid(basis=basis)
                (score,) = scores(less, [step.score.candidate])
                needed.append(Needed(number, score.candidate.joint, score.gain))
        last = superfluous(needed)
        if last is None:
            break
        basis = _without(ground.basis, own, taken[last])
        taken = taken[:last] + taken[last + 1 :]
        ground = ground.relaid(basis=basis)
    return taken, ground


class Needed(NamedTuple):
    """How much an effect still gains beside all others: which one, on which joint, in nats."""

    number: int
    joint: int
    gain: float


def superfluous(needed: Sequence[Needed]) -> int | None:
    """The number of what is needed least, if it is needed too little; else None.

    Too little is less than is claimed at all, and little beside another effect on the same joint:
    a form of that one that is not quite right leaves as much, and the two would share what is the
    one's.
    """

    def share(one: Needed) -> float:
        largest = max(other.gain for other in needed if other.joint == one.joint)
        return one.gain / max(FLOOR, REMAINDER * largest)

    least = min(needed, key=share)
    return least.number if share(least) <= 1.0 else None


def _without(basis: Basis, own: int, step: Step) -> Basis:
    """The basis without the term of a step; the model's own terms come first in it."""
    key = step.score.candidate.key
    found = [term for term in basis.terms[own:] if (term.effect.name, term.joint) != key]
    return Basis((*basis.terms[:own], *found))


def _causes(basis: Basis) -> frozenset[tuple[str, int]]:
    return frozenset((t.effect.name, t.effect.cause(t.joint, t.shape)) for t in basis.terms)


def _candidates(
    ground: Ground, joints: Sequence[int] | range, effects: Mapping[str, Effect] | None
) -> list[Candidate]:
    x = ground.seen
    left = ground.motion.tau - ground.inputs.torque
    swings = [
        Candidate(tone, joint)
        for joint, tone in enumerate(tones(ground.motion.time, left))
        if joint in joints
    ]
    return [*named(x, ground.basis, joints, effects), *unnamed(x, joints), *swings]


def _possible(score: Score, causes: frozenset[tuple[str, int]]) -> bool:
    """Whether hardware could do this; what another joint's does must have been found there."""
    candidate = score.candidate
    if not candidate.named:
        return True
    if candidate.cause == candidate.key:
        return candidate.effect.possible(score.coefficients)
    return candidate.cause in causes


def _stands_out(score: Score, chance: Chance, ground: Ground) -> bool:
    candidate = score.candidate
    large = score.size > LEAST_SIZE * ground.spread[candidate.joint]
    if score.once:
        return large and score.gain > EVENT_FLOOR
    return large and score.gain > FLOOR and chance.beaten_by(score.gain)


def _judge(
    ground: Ground,
    first: Score,
    best: Sequence[Score],
    chance: Chance,
    effects: Mapping[str, Effect] | None,
) -> tuple[Step | None, Ground]:
    """Look again at one joint, with the noise that is left once the best is taken in.

    The best name and the best free curve are each judged with the noise that suits them: with
    that of the other they would look worse than they are.
    """
    joint = first.candidate.joint
    here = [score for score in best if score.candidate.joint == joint and score.gain > 0.0]
    name = next((score for score in (first, *here) if score.candidate.named), None)
    free = next((score for score in (first, *here) if not score.candidate.named), None)
    leaders = [
        score
        for score in (name, free)
        if score is not None and (score is first or score.gain > NEAR * first.gain)
    ]
    if not leaders:
        return None, ground
    explained = [(ground.basis, ground.extra), *(_with(ground, one.candidate) for one in leaders)]
    prior, *priors = threads.side_by_side(lambda one: sharpen(ground, *one), explained)
    # One factor at a time: that of the name, which mostly wins, is made last.
    without = evidence_without(ground, prior)
    views: list[_View] = []
    for leader, prior in reversed(list(zip(leaders, priors, strict=True))):
        seen = None
        view, seen = _View.of(ground, leader, prior, effects)
        views.insert(0, view)
    named_view = max(views, key=lambda view: view.total(view.name), default=None)
    free_view = max(views, key=lambda view: view.total(view.free), default=None)
    if named_view is None or free_view is None or seen is None:
        return None, ground
    chosen, curve = named_view.name, free_view.free
    start = max(view.base for view in views if view.leader is first)
    worth = named_view.total(chosen) - start
    rival_worth = free_view.total(curve) - start
    p_value = chance.p_value(first.gain)
    plain = chosen is not None and chosen.candidate.effect.name in PLAIN
    share = FIRST_SHARE if plain and _bare(ground, joint) else NAME_SHARE
    if chosen is not None and (curve is None or worth > share * rival_worth):
        found, view = chosen, named_view
    elif curve is not None:
        found, view = curve, free_view
    else:
        return None, ground
    if view is not views[0]:
        seen = None
        seen = ground.relaid(view.prior)
    without = max(without, *(view.base for view in views))
    gain = min(found.gain, worth_of(found, seen, without))
    if gain <= FLOOR:
        return None, ground
    left = rivals(found, named_view.others) if found.candidate.named else ()
    step = Step(replace(found, gain=gain), tuple(left), first.gain, p_value, curve)
    return step, seen


@dataclass(frozen=True)
class _View:
    """One joint seen with the noise that one candidate leaves.

    Attributes:
        leader: that candidate.
        prior: with that noise.
        base: log evidence of the ground with it, without the candidate.
        name, others: the best name at its best shape, and the other names.
        free: the best free curve.
    """

    leader: Score
    prior: Prior
    base: float
    name: Score | None
    others: tuple[Score, ...]
    free: Score | None

    @classmethod
    def of(
        cls, ground: Ground, leader: Score, prior: Prior, effects: Mapping[str, Effect] | None
    ) -> tuple["_View", Ground]:
        """The view, and the ground with its prior."""
        again = ground.relaid(prior)
        candidates = _candidates(again, [leader.candidate.joint], effects)
        causes = _causes(again.basis)
        found = [s for s in best_of_each(scores(again, candidates), causes) if _possible(s, causes)]
        # What is led by an event was never held against chance: only events may take its place.
        best = [
            one
            for one in found
            if one.candidate.named and one.gain > 0.0 and (one.once or not leader.once)
        ]
        best = [
            one for number, one in enumerate(best)
            if number < REFINED or one.candidate.effect.name in PLAIN
        ]  # fmt: skip
        bare = _bare(again, leader.candidate.joint)
        names = _plain_first(
            sorted((refined(again, one) for one in best), key=lambda one: -_worth(again, one)),
            FIRST_SHARE if bare else PLAIN_SHARE,
        )
        free = next((one for one in found if not one.candidate.named and one.gain > 0.0), None)
        first = names[0] if names else None
        again.forget()
        view = cls(leader, prior, again.system.log_evidence, first, tuple(names[1:]), free)
        return view, again

    def total(self, score: Score | None) -> float:
        """Log evidence with a candidate: what can be compared between views."""
        return -np.inf if score is None else self.base + score.gain


def _best_gain(ground: Ground, eligible: Sequence[Score]) -> float:
    """Nats that a change of the whole arm must gain more than to come before these.

    Where friction is missing altogether a second Lagrangian takes up much of it.
    """
    bare = any(_bare(ground, score.candidate.joint) for score in eligible)
    return (BARE if bare else 1.0) * max((score.gain for score in eligible), default=0.0)


def _bare(ground: Ground, joint: int) -> bool:
    """Whether the model has no friction on a joint, which every joint has."""
    own = {term.effect.name for term in ground.basis.terms if term.joint == joint}
    return not own & set(PLAIN)


def _plain_first(names: list[Score], least: float) -> list[Score]:
    """Names with what every joint has in front, if it explains so much of what the best does.

    Where plain friction is missing altogether, one curve with a bend does better than either half
    of it: the halves come first, one after the other, and the bend only if it is still needed.
    """
    for score in names:
        if score.candidate.effect.name in PLAIN and score.gain > least * names[0].gain:
            return [score, *(one for one in names if not _over_velocity(one.candidate.effect))]
    return names


def _over_velocity(effect: Effect) -> bool:
    """Whether it may pass for plain friction where that is missing."""
    return effect.kind == "friction" or effect.coordinate == "velocity"


def _worth(ground: Ground, score: Score) -> float:
    """The gain less the price of having tried so many shapes: of equals the simpler comes first."""
    shapes = score.candidate.effect.candidates(ground.seen, score.candidate.joint)
    return score.gain - float(np.log(max(len(shapes), 1)))


def _with(ground: Ground, candidate: Candidate) -> tuple[Basis, tuple[Extra, ...]]:
    """What is explained once a candidate is."""
    if candidate.named:
        return Basis((*ground.basis.terms, candidate.term())), ground.extra
    columns = candidate.columns(ground.seen)
    return ground.basis, (*ground.extra, Extra(candidate.joint, columns))
