"""The points a trajectory needs so that torque that is linear between them is right."""

from itertools import pairwise

import numpy as np

from lagrangian_ff.arrays import Floats, Ints


def needed(time: Floats, tau: Floats, own: Ints, error: Floats) -> Ints:
    """Return the indices of the samples between which torque may be interpolated linearly.

    From the given points on the sample that is worst is added, until no sample of any joint is
    farther than `error` from the line (Ramer 1972, Douglas and Peucker 1973).

    Args:
        time: (L,) s, increasing.  tau: (L, N) N·m.
        own: (K,) increasing indices of the samples that are points already, the ends among them.
        error: (N,) N·m.

    Returns:
        (M,) increasing indices, `own` among them.
    """
    chosen = list(own)
    waiting = list(pairwise(own))
    while waiting:
        left, right = waiting.pop()
        if right - left < 2:
            continue
        inner = slice(left + 1, right)
        share = (time[inner, None] - time[left]) / (time[right] - time[left])
        line = tau[left] * (1.0 - share) + tau[right] * share
        excess = np.max(np.abs(tau[inner] - line) / error, axis=1)
        worst = int(np.argmax(excess))
        if excess[worst] > 1.0:
            middle = left + 1 + worst
            chosen.append(middle)
            waiting += [(left, middle), (middle, right)]
    return np.sort(np.array(chosen))


def linear_error(time: Floats, tau: Floats, at: Ints) -> Floats:
    """Return (N,) N·m, the largest error of torque that is linear between the samples `at`."""
    columns = range(tau.shape[1])
    line = np.stack([np.interp(time, time[at], tau[at, column]) for column in columns], axis=1)
    return np.asarray(np.abs(tau - line).max(axis=0))
