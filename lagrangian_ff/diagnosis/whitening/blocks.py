"""Blocks of time that are as good as independent: how long the residual of a motion remembers."""

import numpy as np

from lagrangian_ff.diagnosis.whitening.whitened import Whitened
from lagrangian_ff.sampling import usual_step

LONGEST, SHORTEST = 2.0, 0.1
"""s, of a block."""
MEMORIES = 4.0
"""Length of a block in correlation times: two neighbours then share about a sixteenth."""
MANY = 30
"""Number of blocks beyond which longer ones are better than more."""
REMEMBERED = 4.0
"""s, over which correlation is looked for."""


def memory(whitened: Whitened) -> float:
    """Return the integral correlation time of the whitened residual in s.

    It is that of the joint that remembers longest; the step between samples where none does.
    """
    time, segment = whitened.x.time, whitened.x.segment
    residual = whitened.residual.reshape(len(time), -1)
    step = usual_step(time, segment)
    if not 0.0 < step < np.inf:
        return LONGEST / MEMORIES
    power = np.mean(residual**2, axis=0)
    remembered = np.ones_like(power)
    open_ = power > 0.0
    for lag in range(1, min(len(time) // 4, int(REMEMBERED / step)) + 1):
        apart = time[lag:] - time[:-lag]
        near = (segment[lag:] == segment[:-lag]) & (np.abs(apart - lag * step) < 0.5 * step)
        if near.sum() < 10 or not open_.any():
            break
        shared = np.mean((residual[lag:] * residual[:-lag])[near], axis=0)
        correlation = shared / np.where(power > 0.0, power, 1.0)
        # Beyond the first lag that chance explains, all is chance.
        open_ &= correlation > 2.0 / np.sqrt(near.sum())
        remembered += 2.0 * np.where(open_, correlation, 0.0)
    return float(step * remembered.max())


def shortest_seconds(whitened: Whitened) -> float:
    """Return the length in s from which on blocks are as good as independent."""
    return float(np.clip(MEMORIES * memory(whitened), SHORTEST, LONGEST))


def block_seconds(whitened: Whitened) -> float:
    """Return the length of blocks in s: what is remembered, or more where there is much motion."""
    moved = len(whitened.index) * usual_step(whitened.x.time, whitened.x.segment)
    return max(shortest_seconds(whitened), min(moved / MANY, LONGEST))
