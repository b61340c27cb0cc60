"""Intervals that hold although errors are no white noise: by a jackknife, and by calibration."""

from dataclasses import dataclass
from statistics import NormalDist

import numpy as np
import scipy

from lagrangian_ff.arrays import Floats, Ints
from lagrangian_ff.effects import Inputs
from lagrangian_ff.errors import ModelError
from lagrangian_ff.identification.blueprint import Blueprint, Solved
from lagrangian_ff.identification.samples import Samples, evenly, groups
from lagrangian_ff.identification.solving.low_rank import LOOKED
from lagrangian_ff.identification.solving.posterior import Posterior, exact
from lagrangian_ff.identification.solving.robust import outliers_of
from lagrangian_ff.identification.solving.system import System
from lagrangian_ff.kernels.threads import one_blas_thread

LEVEL = 0.9
"""The share of such intervals that should hold the true value."""
QUICK = 100
"""Samples of the form whose calibration a model keeps: a fit of them takes 10 ms for six joints."""


def reach(posterior: Posterior, block: Ints) -> Floats:
    """Return half the width of 90 % intervals of the effects' parameters.

    The wider of two is taken: the model's own standard deviation, which assumes independent noise,
    and the jackknife over blocks of time (Künsch 1989), which does not. Both follow from the factor
    of the fit.

    Args:
        block: (M,) the block of time each training sample lies in.

    Returns:
        (B,) in the parameters' physical units.
    """
    own = posterior.deviations
    blocks = groups(block)
    if len(blocks) < 3 or not len(own):
        return np.asarray(own * scipy.special.stdtrit(max(1, len(blocks) - 1), 0.5 + LEVEL / 2.0))
    changed = posterior.changed(blocks)
    count = len(blocks)
    spread = changed - changed.mean(axis=0)
    jackknife = np.sqrt((count - 1) / count * np.sum(spread**2, axis=0))
    factor = scipy.special.stdtrit(count - 1, 0.5 + LEVEL / 2.0)
    return np.asarray(np.maximum(own, jackknife) * factor)


def calibrated(blueprint: Blueprint, solved: Solved, residual: Floats) -> Floats:
    """Return (N,) the factors on the standard deviations of a fit; outliers do not count.

    Args:
        blueprint: of the model.  solved: its solution.
        residual: (S, N) N·m, of blocks left out.
    """
    expected = solved.weighed.left_out_deviation(blueprint.apart)
    expected[outliers_of(solved.posterior.problem.samples.weights)] = np.nan
    return factors(residual, expected, len(np.unique(blueprint.seconds)))


def factors(residual: Floats, deviation: Floats, independent: int) -> Floats:
    """Return (N,) the factors on the joints' standard deviations.

    With them, the share `LEVEL` of the residuals of blocks left out lies within the intervals of
    a fit without them (conformal prediction, Lei et al. 2018, J. Am. Stat. Assoc. 113(523), with
    blocks of time in place of single samples).

    Args:
        residual: (M, N) N·m, see `Posterior.left_out`.
        deviation: (M, N) N·m that the model expects, see `Posterior.left_out_deviation`; NaN does
            not count.
        independent: number of independent residuals; the fewer, the further the quantile lies
            above `LEVEL`.
    """
    level = min(1.0, LEVEL * (independent + 1) / independent)
    ratio = np.abs(residual) / deviation
    usual = NormalDist().inv_cdf(0.5 + LEVEL / 2.0)
    return np.asarray(np.nanquantile(ratio, level, axis=0) / usual)


@dataclass(frozen=True)
class SubsetOfData:
    """Fits of a subset of a model's samples: the cheap form of uncertainty.

    Attributes:
        made: blueprint of the model, with the weights that its fit ended with.
        x: (S, N) the samples learned from, as effects see them.
        weight: (S, N) IRLS weights that intervals are made with.
        samples: size of the subset, evenly spread.
    """

    made: Blueprint
    x: Inputs
    weight: Floats
    samples: int

    def fit(self, among: Ints | None = None) -> Posterior[System]:
        """Return a fit of a subset of the samples in `among`; None is all.

        Raises:
            NotPositiveDefiniteError: the noise is too small for the arithmetic.
        """
        made = self.made
        among = np.arange(len(self.x)) if among is None else among
        some = among[evenly(len(among), self.samples)]
        tau = made.data.tau[made.seen[some]]
        return exact(made.problem(Samples(self.x.take(some), tau, None, self.weight[some])))

    def factor(self, residual: Floats) -> Floats:
        """Return (N,) the factors on its standard deviations; see `calibrated`.

        Args:
            residual: (S, N) N·m, of blocks left out of the model's own fit.

        Raises:
            ModelError: the training motion is a single block.
        """
        made, everything = self.made, np.arange(len(self.x))
        if len(made.apart) < 2:
            raise ModelError(
                "how sure the model is shows on blocks of its training motion left out in turn, "
                "but that is a single block: identify from a longer recording, or with a shorter "
                "--block"
            )
        expected = np.full(self.x.q.shape, np.nan)
        # Threads cost more than they bring on matrices as small as these.
        with one_blas_thread():
            for group in made.apart:
                seen = group[evenly(len(group), LOOKED)]
                without = self.fit(np.setdiff1d(everything, group))
                expected[seen] = without.variance(self.x.take(seen)).whole
        if made.weight is not None:
            expected[outliers_of(made.weight)] = np.nan
        return factors(residual, np.sqrt(expected), len(np.unique(made.seconds)))
