"""Which samples of many: some of them, or those that belong together."""

import numpy as np
from numpy.typing import NDArray

Ints = NDArray[np.int64]


def groups(part: Ints) -> list[Ints]:
    """The samples of each part, given the one that each sample lies in (M,)."""
    return [np.flatnonzero(part == number) for number in np.unique(part)]


def evenly(available: int, wanted: int) -> Ints:
    """Positions of at most `wanted` samples, evenly spread over those available."""
    if wanted >= available:
        return np.arange(available)
    return np.round(np.linspace(0, available - 1, wanted)).astype(np.int64)
