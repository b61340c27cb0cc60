"""Cubic splines through samples and near them.

Written out since importing scipy.interpolate takes longer than conditioning a minute of motion.
"""

import numpy as np
import scipy

from lagrangian_ff.arrays import Floats, Ints


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


_STIFFNESS = 1e-8  # of the samples in a piece: joins pieces that have none


class LeastSquares:
    """Cubic splines of equal pieces near samples.

    Attributes:
        piece: the length of one.
    """

    def __init__(self, x: Floats, pieces: int, span: Floats | None = None) -> None:
        """Take the places (K,) of the samples, in any order, and the first and last place."""
        first, last = (float(x.min()), float(x.max())) if span is None else span
        self.piece = (last - first) / pieces
        self._first, self._pieces = first, pieces
        at, u = self._places(x)
        v = 1.0 - u
        basis = _four(u)
        slope = np.stack([-(v**2), u * (3 * u - 4), v * (4 - 3 * v), u**2]) / (2.0 * self.piece)
        self._basis, self._slope = self._table(basis, at), self._table(slope, at)
        normal = np.zeros((4, pieces + 3))  # its upper diagonals, the main one last
        stiff = _STIFFNESS * max(1.0, len(x) / pieces)
        for back, weight in enumerate((20.0, -15.0, 6.0, -1.0)):
            for i in range(4 - back):
                together = np.bincount(at, basis[i] * basis[i + back], pieces)
                normal[3 - back, i + back : i + back + pieces] += together
            normal[3 - back, back:] += stiff * weight
        self._factor = scipy.linalg.cholesky_banded(normal)

    def fit(self, values: Floats) -> Floats:
        """Return the weights (pieces + 3, ...) of the B-splines nearest to values (K, ...)."""
        right = self._basis.T @ values
        return np.asarray(scipy.linalg.cho_solve_banded((self._factor, False), right))

    def values(self, weights: Floats, at: Floats | None = None) -> Floats:
        """Return the splines at the samples, (K, ...), or at other places (M,) in the span."""
        if at is None:
            return np.asarray(self._basis @ weights)
        piece, u = self._places(at)
        return np.asarray(self._table(_four(u), piece) @ weights)

    def slopes(self, weights: Floats) -> Floats:
        """Return their derivatives at the samples, (K, ...)."""
        return np.asarray(self._slope @ weights)

    def _places(self, x: Floats) -> tuple[Ints, Floats]:
        """Return the pieces in which places lie, and where in their pieces, from 0 to 1."""
        u = (x - self._first) / self.piece
        at = np.clip(u.astype(np.int64), 0, self._pieces - 1)
        return at, u - at

    def _table(self, four: Floats, at: Ints) -> "scipy.sparse.csr_array":
        """Return the matrix of the values (4, K) of the splines that are not zero in a piece."""
        columns = (at[:, np.newaxis] + np.arange(4)).ravel()
        rows = np.arange(0, 4 * len(at) + 1, 4)
        shape = len(at), self._pieces + 3
        return scipy.sparse.csr_array((four.T.ravel(), columns, rows), shape=shape)


def _four(u: Floats) -> Floats:
    """Return (4, K) the B-splines that are not zero in a piece, at places from 0 to 1 in it."""
    v = 1.0 - u
    return np.stack([v**3, 3 * u**3 - 6 * u**2 + 4, 3 * v**3 - 6 * v**2 + 4, u**3]) / 6.0
