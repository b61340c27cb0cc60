"""When a joint turns round, told from a velocity that holds noise."""

from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from lagrangian_ff.recording.motion import Motion

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

REST_SHARE = 0.01
"""Of the joint's largest speed: slower than this, the sign of the velocity may be noise."""


def direction(motion: Motion, joint: int) -> Floats:
    """(M,) +1 or -1, the way the joint moves or last moved; NaN before it first moves.

    The sign changes where the velocity crosses zero, but only if it then leaves the band in which
    it may be noise: a joint that stands still keeps the direction it came with.
    """
    qd = motion.qd[:, joint]
    rest = REST_SHARE * float(np.abs(qd).max(initial=0.0))
    moving = np.abs(qd) > rest
    out = np.full(len(qd), np.nan)
    for begin, end in _stretches(motion.segment):
        sure = begin + np.flatnonzero(moving[begin:end])
        if not len(sure):
            continue
        signs = np.sign(qd[sure])
        turns = np.flatnonzero(np.diff(signs)) + 1
        starts = [begin, *(_crossing(qd, sure[k - 1], sure[k]) for k in turns)]
        for first, last, sign in zip(
            starts, [*starts[1:], end], [signs[0], *signs[turns]], strict=True
        ):
            out[first:last] = sign
    return out


def since_reversal(motion: Motion, joint: int) -> Floats:
    """(M,) s since the joint last turned round; NaN before it first does in a segment."""
    out = np.full(len(motion), np.nan)
    for turns, _, end in _turns(motion, joint):
        for first, last in pairwise([*turns, end]):
            out[first:last] = motion.time[first:last] - motion.time[first]
    return out


def before_reversal(motion: Motion, joint: int) -> Floats:
    """(M,) s until the joint next turns round; NaN after it last does in a segment."""
    out = np.full(len(motion), np.nan)
    for turns, begin, _ in _turns(motion, joint):
        for first, last in pairwise([begin, *turns]):
            out[first:last] = motion.time[last] - motion.time[first:last]
    return out


def _turns(motion: Motion, joint: int) -> list[tuple[list[int], int, int]]:
    """Of each stretch: the first samples after the reversals, its begin and its end."""
    sign = direction(motion, joint)
    found = []
    for begin, end in _stretches(motion.segment):
        part = sign[begin:end]
        turned = np.isfinite(part[1:] + part[:-1]) & (part[1:] != part[:-1])
        found.append(([begin + 1 + int(k) for k in np.flatnonzero(turned)], begin, end))
    return found


def _stretches(segment: Ints) -> list[tuple[int, int]]:
    """Begin and end of every uninterrupted stretch."""
    cuts = [0, *(np.flatnonzero(np.diff(segment)) + 1), len(segment)]
    return [(int(a), int(b)) for a, b in pairwise(cuts) if b > a]


def _crossing(qd: Floats, before: int, after: int) -> int:
    """The first sample of the last run of `after`'s sign, between two samples of unlike sign."""
    other = np.flatnonzero(qd[before : after + 1] * qd[after] <= 0.0)
    return before + int(other[-1]) + 1
