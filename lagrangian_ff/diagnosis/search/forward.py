"""One effect at a time: find the best, take it in, choose the noise anew, look again."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from lagrangian_ff.diagnosis.ground import Ground, Prior, lay, sharpen
from lagrangian_ff.diagnosis.ground.ground import Extra
from lagrangian_ff.diagnosis.search.candidates import Candidate, named, unnamed
from lagrangian_ff.diagnosis.search.chance import Chance
from lagrangian_ff.diagnosis.search.gain import Score, scores
from lagrangian_ff.diagnosis.search.refine import refined
from lagrangian_ff.diagnosis.search.rivals import best_of_each, rivals
from lagrangian_ff.effects import Effect
from lagrangian_ff.identification.basis import Basis
from lagrangian_ff.progress import Progress, silent

MOST_STEPS = 6
FLOOR = 8.0
"""Nats below which nothing is claimed, whatever chance says."""
LEAST_SIZE = 0.005
"""Share of a joint's torque below which an effect is not worth a name."""
NAME_SHARE = 0.7
"""A name must explain this share of what a free curve over one coordinate does."""


@dataclass(frozen=True)
class Step:
    """Something that was missing.

    Attributes:
        score: the best candidate, judged once the noise was chosen with it in the model.
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
        ground: the last one, with all steps taken in.
        first: the ground of the first look.
    """

    steps: tuple[Step, ...]
    all: tuple[Score, ...]
    ranking: tuple[Score, ...]
    last: tuple[Score, ...]
    chance: Chance
    ground: Ground
    first: Ground


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
    first = ground
    taken: list[Step] = []
    looks: list[tuple[list[Score], list[Score], Chance]] = []
    while True:
        share = len(taken) / (steps + 1)
        progress(share, f"looking at every effect, step {len(taken) + 1}")
        found = list(scores(ground, _candidates(ground, range(ground.joints), effects)))
        looks.append((found, best_of_each(found), Chance.of(found)))
        _, best, chance = looks[-1]
        eligible = [score for score in best if _stands_out(score, chance, ground)]
        if not eligible or len(taken) == steps:
            break
        progress(
            share + 0.5 / (steps + 1), f"looking closer at {eligible[0].candidate.source.name}"
        )
        step, prior = _judge(ground, eligible[0], chance, effects)
        if step is None:
            break
        taken.append(step)
        ground = _relaid(ground, prior, *_with(ground, step.score.candidate))
    every, ranking, chance = looks[0]
    return Search(
        tuple(taken), tuple(every), tuple(ranking), tuple(looks[-1][1]), chance, ground, first
    )


def _candidates(
    ground: Ground, joints: Sequence[int] | range, effects: Mapping[str, Effect] | None
) -> list[Candidate]:
    x = ground.seen
    return [*named(x, ground.basis, joints, effects), *unnamed(x, joints)]


def _stands_out(score: Score, chance: Chance, ground: Ground) -> bool:
    large = score.size > LEAST_SIZE * ground.spread[score.candidate.joint]
    return large and score.gain > max(FLOOR, chance.threshold)


def _judge(
    ground: Ground, first: Score, chance: Chance, effects: Mapping[str, Effect] | None
) -> tuple[Step | None, Prior]:
    """Look again at one joint, with the noise that is left once the best is taken in."""
    prior = sharpen(ground, *_with(ground, first.candidate))
    again = _relaid(ground, prior, ground.basis, ground.extra)
    joints = [first.candidate.joint]
    best = best_of_each(scores(again, _candidates(again, joints, effects)))
    names = [refined(again, one) for one in best if one.candidate.named and one.gain > 0.0][:8]
    names.sort(key=lambda score: -score.gain)
    free = next((one for one in best if not one.candidate.named and one.gain > 0.0), None)
    if not names and free is None:
        return None, prior
    chosen, left = names[0] if names else None, tuple(rivals(names[0], names[1:])) if names else ()
    if chosen is None or (free is not None and chosen.gain < NAME_SHARE * free.gain):
        assert free is not None
        chosen, left = free, ()
    return Step(chosen, left, first.gain, chance.p_value(first.gain), free), prior


def _with(ground: Ground, candidate: Candidate) -> tuple[Basis, tuple[Extra, ...]]:
    """What is explained once a candidate is."""
    if candidate.named:
        return Basis((*ground.basis.terms, candidate.term())), ground.extra
    columns = candidate.columns(ground.seen)
    return ground.basis, (*ground.extra, Extra(candidate.joint, columns))


def _relaid(ground: Ground, prior: Prior, basis: Basis, extra: tuple[Extra, ...]) -> Ground:
    return lay(ground.motion, ground.index, ground.block, ground.inputs, prior, basis, extra)
