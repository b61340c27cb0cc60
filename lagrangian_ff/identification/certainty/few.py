"""The cheap form of certainty: a fit of few samples, calibrated on what all of them met."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from threadpoolctl import threadpool_limits

from lagrangian_ff.effects import Inputs
from lagrangian_ff.errors import ModelError
from lagrangian_ff.identification.blueprint import Blueprint
from lagrangian_ff.identification.certainty.calibration import factors
from lagrangian_ff.identification.certainty.outliers import doubtful
from lagrangian_ff.identification.samples import evenly
from lagrangian_ff.identification.solving.equations import fit_basis
from lagrangian_ff.identification.solving.fit import Fit
from lagrangian_ff.identification.solving.low_rank import LOOKED
from lagrangian_ff.identification.solving.system import System

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

QUICK = 100
"""Samples of the form whose calibration a model keeps: a fit of them takes 10 ms for six joints."""


@dataclass(frozen=True)
class Few:
    """Fits of few of a model's samples.

    Attributes:
        made: what the model is made from, with the trust that its fit ended with.
        x: (S, N) the samples learned from, as effects see them.
        trust: (S, N) in each torque, as certainty takes it.
        samples: how many are taken, evenly spread.
    """

    made: Blueprint
    x: Inputs
    trust: Floats
    samples: int

    def fit(self, among: Ints | None = None) -> Fit[System]:
        """A fit of few of these samples, or of few of all.

        Raises:
            NotPositiveDefiniteError: the noise is too small for the arithmetic.
        """
        made = self.made
        among = np.arange(len(self.x)) if among is None else among
        some = among[evenly(len(among), self.samples)]
        tau = made.data.tau[made.seen[some]]
        return fit_basis(
            made.basis, made.choice, self.x.take(some), tau, made.scaling, self.trust[some]
        )

    def factor(self, met: Floats) -> Floats:
        """(N,) what its deviations are to be multiplied with; see `calibrated`.

        Args:
            met: (S, N) N·m, the residuals of blocks left out of the model's own fit.

        Raises:
            ModelError: there is no second block to learn from while one is left out.
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
        with threadpool_limits(1):
            for group in made.apart:
                seen = group[evenly(len(group), LOOKED)]
                without = self.fit(np.setdiff1d(everything, group))
                expected[seen] = without.variance(self.x.take(seen)).whole
        if made.trust is not None:
            expected[doubtful(made.trust)] = np.nan
        return factors(met, np.sqrt(expected), len(np.unique(made.seconds)))
