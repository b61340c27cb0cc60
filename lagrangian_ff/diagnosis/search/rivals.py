"""Which candidates the data cannot tell from the best one (Vuong 1989, by blocks of time)."""

from collections.abc import Iterable, Sequence
from collections.abc import Set as AbstractSet

import numpy as np
from numpy.typing import NDArray

from lagrangian_ff.diagnosis.search.gain import Score

Floats = NDArray[np.float64]

DEVIATIONS = 2.0
LEAST = 4.0
"""Nats by which a rival must fall behind, and standard deviations of that, to be ruled out."""
SAME_CAUSE = 0.7
"""The share of the best one's gain that a cause found already must reach to be taken again."""
WORTHY = 0.25
"""The share of the best one's gain that makes a rival at all."""


def best_of_each(
    found: Iterable[Score], causes: AbstractSet[tuple[str, int]] = frozenset()
) -> list[Score]:
    """For every effect and joint the score at its best shape, best first.

    Args:
        found: all scores.
        causes: that were found on other joints already, as `Candidate.cause`. They are taken where
            another explains hardly more: a gear that gives way must shake other joints, a second
            one would be chance.
    """
    best: dict[tuple[str, int], Score] = {}
    known: dict[tuple[str, int], Score] = {}
    for score in found:
        key = score.candidate.key
        for held in (best, known) if score.candidate.cause in causes else (best,):
            if key not in held or score.gain > held[key].gain:
                held[key] = score
    again = {k: score for k, score in known.items() if score.gain > SAME_CAUSE * best[k].gain}
    return sorted({**best, **again}.values(), key=lambda score: -score.gain)


def rivals(
    best: Score, others: Sequence[Score], more: Sequence[tuple[Floats, Floats]] = ()
) -> list[Score]:
    """The named candidates that are not clearly worse than the best.

    Args:
        best: the best one.
        others: at their best shapes, of the same ground.
        more: for each of the others, what another recording says: (B,) nats gained by block by
            the best and by the other, with frozen coefficients.
    """
    left = []
    for number, other in enumerate(others):
        if not other.candidate.named or other.candidate.key == best.candidate.key:
            continue
        behind = best.gain - other.gain
        differences = best.likelihood - other.likelihood
        scatter = len(differences) * float(np.var(differences))
        if more:
            mine, its = more[number]
            behind += float(np.sum(mine - its))
            scatter += len(mine) * float(np.var(mine - its))
        worthy = other.gain > max(LEAST, WORTHY * best.gain)
        if worthy and behind < max(LEAST, DEVIATIONS * np.sqrt(scatter)):
            left.append(other)
    return left
