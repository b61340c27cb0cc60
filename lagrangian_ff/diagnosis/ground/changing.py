"""The evidence of some samples where another Lagrangian is added from some moment on.

Up to that moment the Gram matrix is as it was, and so is its factor U: what is left to factor are
the later rows, K₂₂ + D₂ − U₁₂ᵀ U₁₂ and what is added.
"""

from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import blas, lapack, solve_triangular

from lagrangian_ff.diagnosis.ground.ground import Extra, Ground
from lagrangian_ff.diagnosis.ground.prior import Prior, within
from lagrangian_ff.diagnosis.ground.tuning import FAILED, Part, part_of
from lagrangian_ff.effects import Inputs
from lagrangian_ff.identification.solving.solution import NotPositiveDefiniteError
from lagrangian_ff.identification.solving.system import System
from lagrangian_ff.kernels import States

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Changing:
    """The log evidence as a function of a change, see `Prior`.

    Attributes:
        x: the samples.
        prior: without a change.
        plain: their system without one; None where it has no factor.
    """

    x: Inputs
    prior: Prior
    plain: System | None
    _later: dict[int, tuple[Floats, Floats]] = field(default_factory=dict)

    @classmethod
    def of(cls, ground: Ground, samples: int, extra: tuple[Extra, ...] = ()) -> "Changing":
        """Of some samples of a ground, explained by its basis and what is given besides."""
        prior = replace(ground.prior, change=None)
        some = part_of(ground.motion, ground.inputs, samples, extra, ground)
        every = samples == len(ground.index) and ground.prior.change is None
        return cls(some.x, prior, _plain(some, prior, ground, every=every))

    def gain(self, change: tuple[float, float, float]) -> float:
        """Nats of log evidence that a change is worth; minus infinity where there is no factor."""
        changed = np.repeat(within(change, self.x), self.x.joints)
        if self.plain is None or not changed.any():
            return 0.0
        first = int(np.argmax(changed)) // self.x.joints * self.x.joints
        kernel, left = self._beyond(first)
        matrix = left.copy(order="F")
        felt = np.flatnonzero(changed[first:])
        part = (
            np.ix_(felt, felt) if len(felt) <= felt[-1] else np.index_exp[: len(felt), : len(felt)]
        )
        with np.errstate(all="ignore"):  # what memory held below the diagonal
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
        grown = float(np.sum(np.log(np.diag(upper) / own)))
        return changed_system.log_evidence - grown - plain.log_evidence

    def _beyond(self, first: int) -> tuple[Floats, Floats]:
        """The kernel's Gram matrix of the rows from `first` on, and what is left of it there.

        Of both the upper triangle is written.
        """
        if first not in self._later:
            assert self.plain is not None
            self._later.clear()
            rows = slice(first // self.x.joints, None)
            states = States(self.x.q[rows], self.x.qd[rows], self.x.qdd[rows])
            kernel = self.prior.kernel.gram(states).T
            left = kernel.copy(order="F")
            left.T.flat[:: len(left) + 1] += self.plain.noise[first:]
            if first:
                across = self.plain.upper[:first, first:]
                left = blas.dsyrk(-1.0, across, beta=1.0, c=left, trans=1, overwrite_c=1)
            self._later[first] = kernel, left
        return self._later[first]


def _plain(some: Part, prior: Prior, ground: Ground, *, every: bool) -> System | None:
    try:
        return some.system(prior, ground.basis, ground.system if every else None)
    except NotPositiveDefiniteError:
        return None
