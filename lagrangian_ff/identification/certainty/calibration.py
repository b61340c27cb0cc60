"""Making a model's certainty as large as its errors on blocks left out: one factor a joint."""

from statistics import NormalDist

import numpy as np
from numpy.typing import NDArray

from lagrangian_ff.identification.blueprint import Blueprint
from lagrangian_ff.identification.certainty.intervals import LEVEL
from lagrangian_ff.identification.certainty.outliers import doubtful
from lagrangian_ff.identification.solve import Solved

Floats = NDArray[np.float64]


def calibrated(blueprint: Blueprint, solved: Solved, met: Floats) -> Floats:
    """(N,) what the deviations of a fit are to be multiplied with; outliers do not count.

    Args:
        blueprint: what the model is made from.  solved: how.
        met: (S, N) N·m, its residuals of blocks left out.
    """
    expected = solved.weighed.left_out_deviation(blueprint.apart)
    expected[doubtful(solved.fitted.trust)] = np.nan
    return factors(met, expected, len(np.unique(blueprint.seconds)))


def factors(residual: Floats, deviation: Floats, independent: int) -> Floats:
    """(N,) what each joint's standard deviations are to be multiplied with.

    With it, the share `LEVEL` of the residuals of blocks left out lies within the intervals that a
    fit without them gave (conformal prediction, Lei et al. 2018, J. Am. Stat. Assoc. 113(523), with
    blocks of time in place of single samples).

    Args:
        residual: (M, N) N·m that was met, see `Fit.left_out`.
        deviation: (M, N) N·m that was expected, see `Fit.left_out_deviation`; NaN does not count.
        independent: how many of the residuals are; the fewer, the further the quantile that is
            taken lies above `LEVEL`, as conformal prediction has it.
    """
    level = min(1.0, LEVEL * (independent + 1) / independent)
    ratio = np.abs(residual) / deviation
    usual = NormalDist().inv_cdf(0.5 + LEVEL / 2.0)
    return np.asarray(np.nanquantile(ratio, level, axis=0) / usual)
