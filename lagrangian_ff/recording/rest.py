"""Rest: where a joint stands still, and its torque is anywhere within static friction.

A joint at rest says nothing of Coulomb friction, and of gravity only within a band. Rest is found
from the motion alone: a joint rests while its position stays within `STUCK` for `LONG` seconds,
which is slower than any creeping that shows friction over speed.

A joint that has just begun to move says as little. Until its gear has slid, the gear still holds
friction from motion that was not recorded, and nobody knows how much.
"""

import numpy as np

from lagrangian_ff.arrays import Flags, Floats, Ints
from lagrangian_ff.sampling import usual_step

LONG = 0.3
"""Time in s; a reversal is over sooner."""
STUCK = 3e-4
"""Displacement in rad (or m) within `LONG`: gears give way by as much before they slip."""
BEGUN = 5e-3
"""Displacement in rad (or m) from where a segment begins, after which a gear has slid."""
SLOW = 0.1
"""Speed in rad/s (or m/s) from which on a joint counts as sliding when a segment begins: one that
got that fast at 1 rad/s² has moved by `BEGUN`."""
AT_ONCE = 0.05
"""s over which that speed is measured."""


def at_rest(time: Floats, q: Floats, segment: Ints) -> Flags:
    """Return (M, N) where each joint stands still, or has just begun to move.

    Args:
        time: (M,) s; where it is not known, nothing rests.
        q: (M, N) rad.
        segment: (M,) samples recorded without interruption share a number.
    """
    step = usual_step(time, segment) if np.isfinite(time).all() else 0.0
    if step == 0.0:
        return np.zeros(q.shape, dtype=np.bool_)
    begun = _just_begun(time, q, segment, max(1, round(AT_ONCE / step)))
    width = round(LONG / step) + 1
    if width < 3 or len(q) < width:
        return begun
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
    return np.asarray(np.cumsum(ends[:-1], axis=0) > 0) | begun


def _just_begun(time: Floats, q: Floats, segment: Ints, few: int) -> Flags:
    """Return (M, N) where a joint that began slowly has not left the place where it began.

    Args:
        time, q, segment: see `at_rest`.
        few: samples in `AT_ONCE`.
    """
    begins = np.flatnonzero(np.diff(segment, prepend=segment[0] - 1))
    lasts = np.append(begins[1:], len(q)) - 1
    soon = np.minimum(begins + few, lasts)
    elapsed = np.maximum(time[soon] - time[begins], np.finfo(float).tiny)
    slow = np.abs(q[soon] - q[begins]) < SLOW * elapsed[:, None]
    # The segment of each sample; `away` counts the samples so far that were farther than `BEGUN`.
    here = np.repeat(np.arange(len(begins)), lasts - begins + 1)
    away = np.cumsum(np.abs(q - q[begins[here]]) > BEGUN, axis=0)
    return np.asarray(slow[here] & (away == away[begins[here]]))


def _highest(values: Floats, width: int) -> Floats:
    """Return (M - width + 1, N) the largest of each `width` neighbours, by doubling."""
    reach = 1
    while 2 * reach <= width:
        values = np.maximum(values[:-reach], values[reach:])
        reach *= 2
    left = width - reach
    return values if left == 0 else np.maximum(values[:-left], values[left:])
