"""Making a model's certainty as large as its errors on blocks left out: one factor a joint."""

import numpy as np
from numpy.typing import NDArray
from scipy.stats import norm

from lagrangian_ff.identification.blueprint import Blueprint
from lagrangian_ff.identification.fit import Fit
from lagrangian_ff.identification.intervals import LEVEL

Floats = NDArray[np.float64]


def calibrated(blueprint: Blueprint, fitted: Fit) -> Floats:
    """(N,) what the deviations of a fit are to be multiplied with."""
    residual, _ = fitted.left_out(blueprint.apart)
    expected = fitted.left_out_deviation(blueprint.apart)
    return factors(residual, expected, len(np.unique(blueprint.seconds)))


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
    return np.asarray(np.nanquantile(ratio, level, axis=0) / norm.ppf(0.5 + LEVEL / 2.0))
