"""Blocks of time, drawn again or put in another order: what chance alone would show.

Neighbouring samples of a motion are not independent, so that chance is asked block by block.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

BLOCK_SECONDS = 1.0
FEWEST_BLOCKS = 5
"""With fewer, nothing is said of chance."""
REPEATS = 400
"""Bootstrap samples behind a band."""
LEVEL = 0.90
"""Of the bands."""


def resampled(sums: "NDArray[Any]", seed: int, repeats: int = REPEATS) -> Floats:
    """Sums over blocks that are drawn with replacement.

    Args:
        sums: (B, ...) what each of B blocks adds.
        seed: of the draws.
        repeats: R.

    Returns:
        (R, ...) the sums over B blocks drawn R times.
    """
    count = len(sums)
    drawn = np.random.default_rng(seed).multinomial(count, np.full(count, 1.0 / count), repeats)
    return np.asarray(np.tensordot(drawn.astype(np.float64), sums, axes=1))


def band(samples: Floats) -> tuple[Floats, Floats]:
    """The ends of the central `LEVEL` of samples (R, ...); NaN is left out."""
    tail = 0.5 * (1.0 - LEVEL)
    low, high = np.nanquantile(samples, [tail, 1.0 - tail], axis=0)
    return low, high


@dataclass(frozen=True)
class Shuffles:
    """Orders of the blocks in which a residual loses its tie to the motion, not its own course.

    Attributes:
        order: (S, M) the sample that comes to each place.
    """

    order: Ints

    @classmethod
    def of(cls, count: int, block: int, repeats: int, seed: int) -> "Shuffles":
        """Blocks of `block` samples in random order, each time cut at another place."""
        rng = np.random.default_rng(seed)
        size = max(1, min(block, count))
        order = np.empty((repeats, count), dtype=np.int64)
        edges = np.arange(0, count, size)
        for s in range(repeats):
            turned = np.roll(np.arange(count), int(rng.integers(size)))
            blocks = [turned[first : first + size] for first in edges]
            order[s] = np.concatenate([blocks[k] for k in rng.permutation(len(blocks))])
        return cls(order)
