"""Rest: where a joint stands still, and its torque is anywhere within static friction.

A joint at rest says nothing of Coulomb friction, and of gravity only within a band. Rest is found
from the motion alone: a joint rests while its position stays within `STUCK` for `LONG` seconds,
which is slower than any creeping that shows friction over speed.
"""

import numpy as np

from lagrangian_ff.arrays import Flags, Floats, Ints
from lagrangian_ff.sampling import usual_step

LONG = 0.3
"""Time in s; a reversal is over sooner."""
STUCK = 3e-4
"""Displacement in rad (or m) within `LONG`: gears give way by as much before they slip."""


def at_rest(time: Floats, q: Floats, segment: Ints) -> Flags:
    """Return (M, N) where each joint stands still.

    Args:
        time: (M,) s; where it is not known, nothing rests.
        q: (M, N) rad.
        segment: (M,) samples recorded without interruption share a number.
    """
    step = usual_step(time, segment) if np.isfinite(time).all() else 0.0
    width = round(LONG / step) + 1 if step > 0.0 else 0
    if width < 3 or len(q) < width:
        return np.zeros(q.shape, dtype=np.bool_)
    first = np.arange(len(q) - width + 1)
    last = first + width - 1
    whole = segment[first] == segment[last]
    # Samples may be missing within a segment: a pause is no rest.
    whole &= time[last] - time[first] < 2.0 * LONG
    moved = _highest(q, width) + _highest(-q, width)
    stuck = (moved <= STUCK) & whole[:, None]
    ends = np.zeros((len(q) + 1, q.shape[1]), dtype=np.int64)
    ends[: len(stuck)] += stuck
    ends[width:] -= stuck
    return np.asarray(np.cumsum(ends[:-1], axis=0) > 0)


def _highest(values: Floats, width: int) -> Floats:
    """Return (M - width + 1, N) the largest of each `width` neighbours, by doubling."""
    reach = 1
    while 2 * reach <= width:
        values = np.maximum(values[:-reach], values[reach:])
        reach *= 2
    left = width - reach
    return values if left == 0 else np.maximum(values[:-left], values[left:])
