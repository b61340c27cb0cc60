"""Sample rate, length and uninterrupted stretches of a motion that may have gaps."""

from itertools import pairwise

import numpy as np

from lagrangian_ff.arrays import Floats, Ints


def usual_step(time: Floats, segment: Ints | None = None) -> float:
    """Return the median time between neighbouring samples in s; 0 if there are no two.

    Args:
        time: (M,) s.
        segment: (M,) number of the uninterrupted stretch of each sample; steps from one stretch
            to the next do not count.
    """
    steps = np.diff(time)
    if segment is not None:
        steps = steps[np.diff(segment) == 0]
    return float(np.median(steps)) if len(steps) else 0.0


def recorded_seconds(time: Floats, segment: Ints) -> float:
    """Return the time that was recorded in s, gaps left out.

    Args:
        time: (M,) s, increasing within a segment.
        segment: (M,) number of the uninterrupted stretch of each sample.
    """
    return float(np.diff(time)[np.diff(segment) == 0].sum())


def stretches(segment: Ints) -> list[tuple[int, int]]:
    """Return begin and end of every uninterrupted stretch of samples.

    Args:
        segment: (M,) number of the uninterrupted stretch of each sample.
    """
    cuts = [0, *(np.flatnonzero(np.diff(segment)) + 1).tolist(), len(segment)]
    return [(a, b) for a, b in pairwise(cuts) if b > a]
