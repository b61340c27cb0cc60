"""The best shape of an effect, between the values that were tried first."""

from dataclasses import replace

import numpy as np

from lagrangian_ff.diagnosis.ground import Ground
from lagrangian_ff.diagnosis.search.gain import Score, scores

ROUNDS = 3
POINTS = 5


def refined(ground: Ground, best: Score) -> Score:
    """The score with its continuous shapes moved to where the gain is largest, one by one."""
    if not best.candidate.named:
        return best
    effect = best.candidate.effect
    grid = effect.candidates(ground.seen, best.candidate.joint)
    for shape in effect.shapes:
        value = best.candidate.shape.get(shape.name, 0.0)
        if shape.whole or not value > 0.0:
            continue
        tried_first = [one[shape.name] for one in grid if shape.name in one]
        low, high = min(tried_first), max(tried_first)
        if not high > low > 0.0:
            continue
        reach = (high / low) ** (1.0 / max(len(set(tried_first)) - 1, 1))
        for _ in range(ROUNDS):
            value = best.candidate.shape[shape.name]
            around = np.clip(value * reach ** np.linspace(-0.75, 0.75, POINTS), low, high)
            tried = [
                replace(best.candidate, shape={**best.candidate.shape, shape.name: float(v)})
                for v in around
            ]
            best = max([best, *scores(ground, tried)], key=lambda score: score.gain)
            reach = reach**0.5
    return best
