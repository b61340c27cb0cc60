"""When a joint turns round, from a velocity that holds noise."""

from itertools import pairwise

import numpy as np

from lagrangian_ff.arrays import Floats, Ints
from lagrangian_ff.sampling import stretches

REST_SHARE = 0.01
"""Of the joint's largest speed: slower than this, the sign of the velocity may be noise."""


def direction(qd: Floats, segment: Ints, rest: float = REST_SHARE) -> Floats:
    """Return (M,) +1 or -1, the way a joint moves or last moved; NaN before it first moves.

    The sign changes where the velocity crosses zero, but only if it then leaves the band in which
    it may be noise: a joint that stands still keeps the direction it came with.

    Args:
        qd: (M,) rad/s.
        segment: (M,) samples recorded without interruption share a number.
        rest: the half width of that band, as a share of the largest speed; 0: no noise.
    """
    moving = np.abs(qd) > rest * float(np.abs(qd).max(initial=0.0))
    out = np.full(len(qd), np.nan)
    for begin, end in stretches(segment):
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


def since_reversal(time: Floats, qd: Floats, segment: Ints, rest: float = REST_SHARE) -> Floats:
    """Return (M,) s since a joint last turned round; NaN before it first does in a segment."""
    out = np.full(len(time), np.nan)
    for turns, _, end in _turns(qd, segment, rest):
        for first, last in pairwise([*turns, end]):
            out[first:last] = time[first:last] - time[first]
    return out


def travelled(q: Floats, qd: Floats, segment: Ints) -> Floats:
    """Return (M,) rad from where a joint last turned round, or its stretch began.

    Args:
        q, qd: (M,) rad, rad/s.
        segment: (M,) samples recorded without interruption share a number.
    """
    out = np.zeros(len(q))
    for turns, begin, end in _turns(qd, segment, 0.0):
        for first, last in pairwise([begin, *turns, end]):
            out[first:last] = np.abs(q[first:last] - q[first]) if last > first else 0.0
    return out


def before_reversal(time: Floats, qd: Floats, segment: Ints) -> Floats:
    """Return (M,) s until a joint next turns round; NaN after it last does in a segment."""
    out = np.full(len(time), np.nan)
    for turns, begin, _ in _turns(qd, segment, REST_SHARE):
        for first, last in pairwise([begin, *turns]):
            out[first:last] = time[last] - time[first:last]
    return out


def _turns(qd: Floats, segment: Ints, rest: float) -> list[tuple[list[int], int, int]]:
    """Return of each stretch the first samples after the reversals, its begin and its end."""
    sign = direction(qd, segment, rest)
    found = []
    for begin, end in stretches(segment):
        part = sign[begin:end]
        turned = np.isfinite(part[1:] + part[:-1]) & (part[1:] != part[:-1])
        found.append(([begin + 1 + int(k) for k in np.flatnonzero(turned)], begin, end))
    return found


def _crossing(qd: Floats, before: int, after: int) -> int:
    """Return the first sample of the last run of `after`'s sign, between two of unlike sign."""
    other = np.flatnonzero(qd[before : after + 1] * qd[after] <= 0.0)
    return before + int(other[-1]) + 1
