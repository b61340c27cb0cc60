"""The null of the maximum log Bayes factor, and the rivals of the best candidate."""

from collections.abc import Iterable, Iterator, Sequence
from collections.abc import Set as AbstractSet
from dataclasses import dataclass

import numpy as np

from lagrangian_ff.arrays import Floats
from lagrangian_ff.diagnosis import thresholds
from lagrangian_ff.diagnosis.search.bayes_factor import (
    COLUMNS_AT_ONCE,
    BayesFactor,
    tempered_log_bf,
)

DRAWS = 400
ALIKE = 0.2
"""Squared difference of what two candidates explain, over the sum of their squares, below which
their residuals are taken to hold the same noise."""
TIE = 1e-6
"""Relative difference that counts as rounding: with few blocks, some draws flip none or all signs,
and the maximum then ties with itself."""


@dataclass(frozen=True)
class MaximumNull:
    """The null distribution of the largest log Bayes factor over all candidates.

    Each block of residuals keeps its form and gets a random sign. Candidates then explain it by
    chance only, while correlation in time, outliers and the likeness of candidates stay.

    Attributes:
        largest: (R,) nats, sorted.
    """

    largest: Floats

    @classmethod
    def of(cls, found: Sequence[BayesFactor], seed: int = 0) -> "MaximumNull":
        """Return the null of these candidates.

        Args:
            found: all candidates that take part, on one whitened motion.
            seed: of the random signs.
        """
        largest = np.full(DRAWS, -np.inf)
        if found:
            signs = np.random.default_rng(seed).choice([-1.0, 1.0], (DRAWS, len(found[0].blocks)))
            for some in _alike(found):
                sums = signs @ np.stack([score.blocks for score in some])
                information = np.stack([score.information for score in some])
                variance_inflation = np.array([score.variance_inflation for score in some])
                log_bfs = tempered_log_bf(sums, information, variance_inflation)
                np.maximum(largest, log_bfs.max(axis=0), out=largest)
        return cls(np.sort(largest))

    @property
    def threshold(self) -> float:
        """Return the nats above which the p-value is at most `level`."""
        return float(self.largest[-int(thresholds.USED.level * (1 + len(self.largest)))])

    def exceeded_by(self, log_bf: float) -> bool:
        """Return whether the p-value of a log Bayes factor is at most `level`."""
        return self.p_value(log_bf) <= thresholds.USED.level

    def p_value(self, log_bf: float) -> float:
        """Return how often the null reaches a log Bayes factor."""
        above = len(self.largest) - int(np.searchsorted(self.largest, (1.0 - TIE) * log_bf))
        return (1.0 + above) / (1.0 + len(self.largest))


def _alike(found: Sequence[BayesFactor]) -> Iterator[list[BayesFactor]]:
    """Yield scores with equally many parameters together, a few hundred columns at a time."""
    by_width: dict[int, list[BayesFactor]] = {}
    for score in found:
        by_width.setdefault(len(score.information), []).append(score)
    for width, scores in by_width.items():
        step = max(1, COLUMNS_AT_ONCE // max(1, width))
        yield from (scores[first : first + step] for first in range(0, len(scores), step))


def best_of_each(
    found: Iterable[BayesFactor], causes: AbstractSet[tuple[str, int]] = frozenset()
) -> list[BayesFactor]:
    """Return the score at the best shape for every effect and joint, best first.

    Args:
        found: all scores.
        causes: found on other joints already, as `Candidate.cause`. They are preferred where
            another cause explains hardly more: one elastic gear shakes other joints too.
    """
    best: dict[tuple[str, int], BayesFactor] = {}
    known: dict[tuple[str, int], BayesFactor] = {}
    for score in found:
        key = score.candidate.key
        for held in (best, known) if score.candidate.cause in causes else (best,):
            if key not in held or score.log_bf > held[key].log_bf:
                held[key] = score
    share = thresholds.USED.same_cause
    again = {key: one for key, one in known.items() if one.log_bf > share * best[key].log_bf}
    return sorted({**best, **again}.values(), key=lambda score: -score.log_bf)


def lead(one: BayesFactor, other: BayesFactor) -> tuple[float, float]:
    """Return the nats by which a candidate is ahead of another, and their variance by blocks.

    Two that explain nearly the same torque see the same noise, so both get the same variance
    inflation. Their own are estimates from a few dozen blocks with errors of a quarter, and such
    an error alone can put one far ahead.
    """
    differences = one.likelihood - other.likelihood
    scatter = len(differences) * float(np.var(differences))
    # A log likelihood ratio is half the square of what is explained; their difference scatters by
    # the square of the difference.
    if scatter < ALIKE * 2.0 * float(np.sum(one.likelihood + other.likelihood)):
        same = float(np.sqrt(one.variance_inflation * other.variance_inflation))
        return one.tempered(same) - other.tempered(same), scatter
    return one.log_bf - other.log_bf, scatter


def rivals(
    best: BayesFactor, others: Sequence[BayesFactor], more: Sequence[tuple[Floats, Floats]] = ()
) -> list[BayesFactor]:
    """Return the effects that are not clearly worse than the best.

    Args:
        others: at their best shapes, on the same whitened motion.
        more: for each of the others, (B,) nats by block that the best and the other gain on
            another recording, with frozen coefficients.
    """
    limits = thresholds.USED
    left = []
    for number, other in enumerate(others):
        if not other.candidate.named or other.candidate.key == best.candidate.key:
            continue
        behind, scatter = lead(best, other)
        if more:
            mine, its = more[number]
            behind += float(np.sum(mine - its))
            scatter += len(mine) * float(np.var(mine - its))
        strong = other.log_bf > max(limits.rival_nats, limits.rival_share * best.log_bf)
        if strong and behind < max(limits.rival_nats, limits.rival_deviations * np.sqrt(scatter)):
            left.append(other)
    return left
