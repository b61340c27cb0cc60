"""What the best of many candidates gains by chance alone."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lagrangian_ff.diagnosis.search.gain import COLUMNS_AT_ONCE, Score, tempered_gain

Floats = NDArray[np.float64]

DRAWS = 400
LEVEL = 0.05
TIE = 1e-6
"""Relative difference that is no more than rounding: of few blocks, some draws of signs change none
of them, or all, and the best of all then ties with itself."""


@dataclass(frozen=True)
class Chance:
    """The null distribution of the largest gain over all candidates.

    Residuals keep their form within a block of time and get a random sign as a whole, so that
    no candidate can explain them but by chance, while their correlation in time, their
    outliers and the likeness between candidates stay as they are.

    Attributes:
        largest: (R,) nats, sorted.
    """

    largest: Floats

    @classmethod
    def of(cls, found: Sequence[Score], seed: int = 0) -> "Chance":
        """Draw it for these candidates.

        Args:
            found: all that take part, of one ground.
            seed: of the signs.
        """
        largest = np.full(DRAWS, -np.inf)
        if found:
            signs = np.random.default_rng(seed).choice([-1.0, 1.0], (DRAWS, len(found[0].blocks)))
            for some in _alike(found):
                sums = signs @ np.stack([score.blocks for score in some])
                information = np.stack([score.information for score in some])
                inflation = np.array([score.inflation for score in some])
                gains = tempered_gain(sums, information, inflation)
                np.maximum(largest, gains.max(axis=0), out=largest)
        return cls(np.sort(largest))

    @property
    def threshold(self) -> float:
        """Nats that the best of all exceeds by chance once in twenty times."""
        return float(np.quantile(self.largest, 1.0 - LEVEL))

    def beaten_by(self, gain: float) -> bool:
        """Whether a gain is more than that."""
        return gain > (1.0 + TIE) * self.threshold

    def p_value(self, gain: float) -> float:
        """How often chance does as well."""
        above = len(self.largest) - int(np.searchsorted(self.largest, (1.0 - TIE) * gain))
        return (1.0 + above) / (1.0 + len(self.largest))


def _alike(found: Sequence[Score]) -> Iterator[list[Score]]:
    """The scores, those with as many parameters together, a few hundred at a time."""
    by_width: dict[int, list[Score]] = {}
    for score in found:
        by_width.setdefault(len(score.information), []).append(score)
    for width, scores in by_width.items():
        step = max(1, COLUMNS_AT_ONCE // max(1, width))
        yield from (scores[first : first + step] for first in range(0, len(scores), step))
