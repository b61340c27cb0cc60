"""A model's residual over time, and blocks of it, drawn again or in another order.

Neighbouring samples of a motion are not independent, so that chance is estimated block by block.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lagrangian_ff.arrays import Flags, Floats, Ints
from lagrangian_ff.recording.motion import Motion

BLOCK_SECONDS = 1.0
FEWEST_BLOCKS = 5
"""With fewer, nothing is said of chance."""
REPEATS = 400
"""Bootstrap samples behind a band."""
LEVEL = 0.90
"""Of the bands."""


@dataclass(frozen=True)
class ResidualSeries:
    """A model's residual along a measured motion, with what it may depend on.

    Attributes:
        motion: M samples of N joints.
        residual: (M, N) N·m, measured minus predicted.
        load: (M, N) N·m, the model's rigid-body torque: the measured one holds the residual.
        excess: (M,) how far outside the identified range the state is, in parts of the range.
        static: (N,) N·m, static friction as far as the model knows it; None if it knows none.
        rest: (M, N) where each joint stands still; None takes it from the motion.
    """

    motion: Motion
    residual: Floats
    load: Floats
    excess: Floats
    static: Floats | None = None
    rest: Flags | None = None

    @property
    def still(self) -> Flags:
        """Return (M, N) where each joint stands still."""
        return self.motion.rest if self.rest is None else self.rest

    @property
    def too_short(self) -> bool:
        """Return whether there are too few blocks to separate anything from chance."""
        blocks = self.motion.blocks(BLOCK_SECONDS)
        return not len(blocks) or int(blocks[-1]) + 1 < FEWEST_BLOCKS

    def thinned(self, most: int) -> "ResidualSeries":
        """Return at most `most` samples, evenly spread."""
        step = -(-len(self.motion) // most)
        if step <= 1:
            return self
        part = slice(None, None, step)
        arrays = self.residual[part], self.load[part], self.excess[part]
        # Found at the full rate: a few samples show no rest.
        return ResidualSeries(self.motion.take(part), *arrays, self.static, self.still[part])


def resampled(sums: "NDArray[Any]", seed: int = 0) -> Floats:
    """Return sums over blocks that are drawn with replacement.

    Args:
        sums: (B, ...) what each of B blocks adds.

    Returns:
        (R, ...) the sums over B blocks drawn R = `REPEATS` times.
    """
    count = len(sums)
    drawn = np.random.default_rng(seed).multinomial(count, np.full(count, 1.0 / count), REPEATS)
    return np.asarray(np.tensordot(drawn.astype(np.float64), sums, axes=1))


def band(samples: Floats) -> tuple[Floats, Floats]:
    """Return the ends of the central `LEVEL` of samples (R, ...); NaN is left out."""
    tail = 0.5 * (1.0 - LEVEL)
    low, high = np.nanquantile(samples, [tail, 1.0 - tail], axis=0)
    return low, high


def block_orders(time: Floats, repeats: int, seed: int) -> Ints:
    """Return (S, M) orders of blocks of samples: they untie a residual from the motion.

    Args:
        time: (M,) s; the blocks last `BLOCK_SECONDS` and are cut at another place each time.
        repeats: S.  seed: of what is drawn.
    """
    rng = np.random.default_rng(seed)
    count, steps = len(time), np.diff(time)
    step = float(np.median(steps[steps > 0.0])) if (steps > 0.0).any() else BLOCK_SECONDS
    size = max(1, min(round(BLOCK_SECONDS / step), count))
    order = np.empty((repeats, count), dtype=np.int64)
    edges = np.arange(0, count, size)
    for s in range(repeats):
        turned = np.roll(np.arange(count), int(rng.integers(size)))
        blocks = [turned[first : first + size] for first in edges]
        order[s] = np.concatenate([blocks[k] for k in rng.permutation(len(blocks))])
    return order
