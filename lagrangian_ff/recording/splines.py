"""Cubic splines through samples and near them.

Written out since importing scipy.interpolate takes longer than conditioning a minute of motion.
"""

import numpy as np
import scipy

from lagrangian_ff.arrays import Floats


def interpolate(time: Floats, values: Floats, at: Floats) -> Floats:
    """Return the spline through samples (K,), K >= 4, at other times (M,) between them."""
    slope = slopes(time, values)
    left = np.clip(np.searchsorted(time, at, side="right") - 1, 0, len(time) - 2)
    step = time[left + 1] - time[left]
    share = (at - time[left]) / step
    rise = values[left + 1] - values[left]
    begin, end = step * slope[left] - rise, step * slope[left + 1] - rise
    bulge = share * (1.0 - share) * ((1.0 - share) * begin - share * end)
    return np.asarray(values[left] + share * rise + bulge)


def slopes(time: Floats, values: Floats) -> Floats:
    """Return the derivative of the spline through samples (K, ...), K >= 4, at each of them.

    The third derivative is continuous at the second and at the last but one (not-a-knot).
    """
    step = np.diff(time)
    wide = step.reshape(-1, *[1] * (values.ndim - 1))
    chord = np.diff(values, axis=0) / wide
    band, right = np.zeros((3, len(time))), np.empty_like(values)
    band[0, 2:], band[2, :-2] = step[:-1], step[1:]
    band[1, 1:-1] = 2.0 * (step[:-1] + step[1:])
    right[1:-1] = 3.0 * (wide[1:] * chord[:-1] + wide[:-1] * chord[1:])
    for end, beside, first, second in ((0, 0, 0, 1), (-1, 2, -1, -2)):
        both = step[first] + step[second]
        band[1, end], band[beside, 1 if end == 0 else -2] = step[second], both
        right[end] = (
            (step[first] + 2.0 * both) * step[second] * chord[first]
            + step[first] ** 2 * chord[second]
        ) / both
    return np.asarray(scipy.linalg.solve_banded((1, 1), band, right))


def smooth(x: Floats, values: Floats, pieces: int) -> Floats:
    """Return the least-squares spline of equal pieces near samples (K,), at each of them.

    Args:
        x: (K,) increasing, some in each of the pieces.
    """
    u = (x - x[0]) * (pieces / (x[-1] - x[0]))
    piece = np.minimum(u.astype(np.int64), pieces - 1)
    u -= piece
    v = 1.0 - u
    # The four B-splines that are not zero in a piece, six times as high.
    basis = np.stack([v**3, 3 * u**3 - 6 * u**2 + 4, 3 * v**3 - 6 * v**2 + 4, u**3])
    normal, right = np.zeros((pieces + 3, pieces + 3)), np.zeros(pieces + 3)
    for i in range(4):
        right += np.bincount(piece + i, basis[i] * values, pieces + 3)
        for j in range(4):
            together = np.bincount(piece, basis[i] * basis[j], pieces)
            normal[np.arange(pieces) + i, np.arange(pieces) + j] += together
    weights = np.linalg.solve(normal, right)
    return np.asarray(sum(basis[i] * weights[piece + i] for i in range(4)))
