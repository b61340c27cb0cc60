"""What the best of many candidates gains by chance alone."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lagrangian_ff.diagnosis.search.gain import Score

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
            for score in found:
                np.maximum(largest, score.gain_of(signs @ score.blocks), out=largest)
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
