"""What is believed of hyperparameters before any torque is seen."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

PRIOR_DEVIATION = 3.0
"""Standard deviation of the logarithm of a hyperparameter about its start."""
RARITY = 2.0
"""Nats that a torque costs each time it is as large again as its start says."""


@dataclass(frozen=True)
class Belief:
    """A weak prior of logarithms: each is normal about its start.

    Of some variances the square root has an exponential prior besides (Simpson et al., Statistical
    Science 32, 2017): a torque many times as large as what was measured is not believed in, though
    samples that hardly turn a joint may ask for it.

    Attributes:
        middle: (K,) the start.
        variances: (K,) of which logarithms that is said, 1 or 0; None: of none.
    """

    middle: Floats
    variances: Floats | None = field(default=None)

    def height(self, point: Floats) -> float:
        """Log prior, but for a constant, of a point (K,)."""
        away = (point - self.middle) / PRIOR_DEVIATION
        return -0.5 * float(away @ away) - float(np.sum(self._size(point)))

    def slope(self, point: Floats) -> Floats:
        """(K,) its derivative."""
        return (self.middle - point) / PRIOR_DEVIATION**2 - 0.5 * self._size(point)

    def information(self, point: Floats) -> Floats:
        """(K,) minus its second derivatives."""
        return 1.0 / PRIOR_DEVIATION**2 + 0.25 * self._size(point)

    def _size(self, point: Floats) -> Floats:
        if self.variances is None:
            return np.zeros_like(point)
        return RARITY * self.variances * np.exp(0.5 * (point - self.middle))
