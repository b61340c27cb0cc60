"""The log Bayes factor of a second Lagrangian from some moment on, with few samples.

Up to that moment the Gram matrix stays the same, and so does its factor U. Only the later rows are
factored: K₂₂ + D₂ − U₁₂ᵀ U₁₂ plus the second Lagrangian.
"""

from dataclasses import dataclass, field, replace

import numpy as np
from scipy.linalg import blas, lapack, solve_triangular

from lagrangian_ff.arrays import Floats
from lagrangian_ff.diagnosis.whitening.hyperparameters import FAILED, LEAST_NOISE
from lagrangian_ff.diagnosis.whitening.whitened import Whitened
from lagrangian_ff.identification.choosing.evidence import loud
from lagrangian_ff.identification.problem import Problem, within
from lagrangian_ff.identification.samples import evenly
from lagrangian_ff.identification.solving.posterior import exact
from lagrangian_ff.identification.solving.solution import NotPositiveDefiniteError
from lagrangian_ff.identification.solving.system import System
from lagrangian_ff.kernels.dense import gram_of


@dataclass(frozen=True)
class Changing:
    """The log Bayes factor as a function of a change, see `Problem`.

    Attributes:
        problem: without a change.
        plain: its system; None if the Gram matrix has no factor.
    """

    problem: Problem
    plain: System | None
    _later: dict[int, tuple[Floats, Floats]] = field(default_factory=dict)

    @classmethod
    def of(cls, whitened: Whitened, samples: int) -> "Changing":
        """Return the function for some samples of a whitened motion."""
        every = samples == len(whitened.index) and whitened.problem.change is None
        plain = replace(whitened.problem, change=None)
        problem = loud(plain.take(evenly(len(whitened.index), samples)), LEAST_NOISE)
        try:
            like = whitened.system if every else None
            return cls(problem, exact(problem, like=like).system)
        except NotPositiveDefiniteError:
            return cls(problem, None)

    def log_bayes_factor(self, change: tuple[float, float, float]) -> float:
        """Return the nats of a change; hugely negative if the Gram matrix has no factor."""
        x = self.problem.samples.x
        changed = np.repeat(within(change, x), x.joints)
        if self.plain is None or not changed.any():
            return 0.0
        first = int(np.argmax(changed)) // x.joints * x.joints
        kernel, left = self._beyond(first)
        matrix = left.copy(order="F")
        felt = np.flatnonzero(changed[first:])
        part = (
            np.ix_(felt, felt) if len(felt) <= felt[-1] else np.index_exp[: len(felt), : len(felt)]
        )
        with np.errstate(all="ignore"):  # below the diagonal memory is uninitialised
            matrix[part] += change[2] * kernel[part]
        upper, info = lapack.dpotrf(matrix, lower=0, clean=0, overwrite_a=1)
        if info != 0 or not np.isfinite(np.diag(upper)).all():
            return -FAILED
        plain = self.plain
        white = np.column_stack([plain.white_design, plain.white_target])
        rest = np.column_stack([plain.design[first:], plain.target[first:]])
        rest -= plain.upper[:first, first:].T @ white[:first]
        white[first:] = solve_triangular(upper, rest, trans=1, check_finite=False)
        own = np.diag(plain.upper)[first:]
        changed_system = replace(plain, white_design=white[:, :-1], white_target=white[:, -1])
        added = float(np.sum(np.log(np.diag(upper) / own)))
        return changed_system.log_evidence - added - plain.log_evidence

    def _beyond(self, first: int) -> tuple[Floats, Floats]:
        """Return the Gram matrix of the rows from `first` on, and its Schur complement with noise.

        Only the upper triangles are written.
        """
        if first not in self._later:
            assert self.plain is not None
            self._later.clear()
            joints = self.problem.samples.x.joints
            states = self.problem.samples.states.take(slice(first // joints, None))
            kernel = gram_of(self.problem.kernel, states, tuple(range(joints))).T
            left = kernel.copy(order="F")
            left.T.flat[:: len(left) + 1] += self.plain.noise[first:]
            if first:
                across = self.plain.upper[:first, first:]
                left = blas.dsyrk(-1.0, across, beta=1.0, c=left, trans=1, overwrite_c=1)
            self._later[first] = kernel, left
        return self._later[first]
