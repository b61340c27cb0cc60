"""Intervals of parameters: by parts left out, the difference between recordings, and drives' gains.

Errors of a whitened residual are independent only if nothing is wrong with the model. Leaving out
one part of the motion after the other (Künsch 1989, Ann. Stat. 17(3)) does not assume that.
"""

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
import scipy
from scipy.linalg import solve_triangular

from lagrangian_ff.arrays import Floats
from lagrangian_ff.diagnosis.whitening.whitened import Whitened, inverse_rows
from lagrangian_ff.identification.certainty.calibration import LEVEL
from lagrangian_ff.kernels import threads

USUAL = 1.645
"""Half the width of such an interval in standard deviations, if those are known exactly."""
PARTS = 8
"""Parts of a motion that are left out in turn: errors of a wrong model last longer than 2 s."""
GAIN = 0.15
"""Relative error of a drive's gain that nobody measured, at the ends of a 90 % interval."""


def reach(whitened: Whitened, columns: Floats, residual: Floats, covariance: Floats) -> Floats:
    """Return (P,) half the width of 90 % intervals of parameters fitted to a whitened motion.

    The wider of two is taken: from white noise, and from leaving out one part of the motion after
    the other. A part is left out of what the arm's dynamics are learned from as well: an error of
    one recording is the same error all along another.

    Args:
        columns: (n, P) whitened, with what is explained besides projected out.
        residual: (n,) whitened, what they leave, of variance one.
        covariance: (P, P) of the parameters under white noise.
    """
    every = np.hstack([whitened.explained, columns])
    size, known = columns.shape[1], whitened.explained.shape[1]
    joined = np.eye(known + size)
    joined[known:, known:] = covariance
    return _reach(whitened, every, residual, joined)[known:]


def reach_of_all(whitened: Whitened) -> Floats:
    """Return (B,) the same of all that is explained of a whitened motion, effects first."""
    system, amplitude = whitened.system, whitened.amplitude
    columns, covariance = system.white_design / amplitude, system.covariance * amplitude**2
    return _reach(whitened, columns, whitened.residual, covariance)


def _reach(whitened: Whitened, columns: Floats, residual: Floats, covariance: Floats) -> Floats:
    starts = whitened.starts
    parts = min(PARTS, len(starts))
    # Parts matter unequally: they are worth about half as many (Imbens and Kolesár 2016, Rev. Econ.
    # Stat. 98(4)).
    factor = float(scipy.special.stdtrit(max(1, parts // 2), 0.5 + LEVEL / 2.0))
    own = USUAL * np.sqrt(np.maximum(np.diag(covariance), 0.0))
    if parts < 3:
        return np.asarray(own / USUAL * factor)
    first = starts[np.round(np.linspace(0, len(starts), parts, endpoint=False)).astype(int)]
    upper, amplitude = whitened.system.upper, whitened.amplitude
    both = np.column_stack([columns, residual]) / amplitude
    back = solve_triangular(upper, both, check_finite=False)

    def moved(rows: tuple[int, int]) -> Floats:
        half = inverse_rows(upper, *rows) / amplitude
        mine = back[slice(*rows)]
        left = half @ half.T - mine[:, :-1] @ covariance @ mine[:, :-1].T
        return np.asarray(-covariance @ (mine[:, :-1].T @ np.linalg.solve(left, mine[:, -1])))

    ends = pairwise([*first.tolist(), len(residual)])
    changes = np.array(threads.side_by_side(moved, ends))
    spread = np.sum((changes - changes.mean(axis=0)) ** 2, axis=0)
    return np.asarray(np.maximum(own, factor * np.sqrt((parts - 1) / parts * spread)))


def widened(value: Floats, half: Floats, gained: Floats, expected: Floats) -> Floats:
    """Return half the width of intervals that also allow for another size on another recording.

    As far as the size found there differs by more than both uncertainties explain, it varies
    between recordings (DerSimonian and Laird 1986, Control. Clin. Trials 7(3)).

    Args:
        value: (P,) the parameters.  half: (P,) half the width from one recording.
        gained, expected: (G,) nats of groups of the other recording, see `HoldOut`.
    """
    power = 2.0 * expected
    if len(power) < 3 or not power.sum() > 0.0:
        return half
    each = (gained + expected) / np.where(power > 0.0, power, np.inf)
    ratio = float(power @ each / power.sum())
    scatter = float(np.sum((power * (each - ratio)) ** 2)) * len(power) / (len(power) - 1)
    known = scatter / float(power.sum()) ** 2 + 1.0 / float(power.sum())
    own = (half / USUAL / np.where(value != 0.0, np.abs(value), np.inf)) ** 2
    varies = np.maximum((ratio - 1.0) ** 2 - known - own, 0.0) / 2.0
    return np.asarray(np.hypot(half, USUAL * np.abs(value) * np.sqrt(varies)))


def gain_reach(parts: Sequence[Floats], unknown: Floats) -> Floats:
    """Return (P,) half the width of intervals that unknown gains of the drives alone make.

    Args:
        parts: (P,) for each joint, the share of the parameters that its torque determines.
        unknown: (N,) relative error of each joint's gain at the ends of a 90 % interval.
    """
    each = [np.asarray(part) * error for part, error in zip(parts, unknown, strict=True)]
    return np.asarray(np.sqrt(np.sum(np.square(each), axis=0)))
