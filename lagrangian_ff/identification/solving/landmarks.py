"""Landmarks: the few states on which a kernel is built that many samples are learned from.

With Z the landmarks and K_ZZ = Lᵀ L, a state has the features ψ(x) = L⁻ᵀ k_Z(x), whose products are
the kernel of all torques that the landmarks can tell apart: K ≈ Ψ Ψᵀ, exact at the landmarks
(subset of regressors; Quiñonero-Candela and Rasmussen, JMLR 6, 2005). The factor is a Cholesky
with pivots, so that torques of landmarks that follow from the others are left out.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import lapack, solve_triangular

from lagrangian_ff.identification.solving.solution import NotPositiveDefiniteError
from lagrangian_ff.kernels import Kernel, States
from lagrangian_ff.kernels.base import CHUNK_ENTRIES
from lagrangian_ff.kernels.dense import cross_of, gram_of

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

FOLLOWS = 1e-12
"""A torque of a landmark with less than this share of its prior variance left is not a feature."""


@dataclass(frozen=True)
class Landmarks:
    """The landmarks of the joints that are solved together, and their factor.

    Attributes:
        kernel: of the torques.  states: (C, N).  joints: the n joints that are solved together.
        pivots: (M,) which of the C n torques are features.
        scale: (M,) their prior standard deviation.
        upper: (M, M) L, of their correlations.
    """

    kernel: Kernel
    states: States
    joints: tuple[int, ...]
    pivots: Ints
    scale: Floats
    upper: Floats

    @classmethod
    def of(cls, kernel: Kernel, states: States, joints: tuple[int, ...]) -> "Landmarks":
        """Factor the Gram matrix of some states.

        Raises:
            NotPositiveDefiniteError: it is not finite.
        """
        gram = gram_of(kernel, states, joints)
        scale = np.sqrt(np.diag(gram))
        if not np.isfinite(scale).all():
            raise NotPositiveDefiniteError(f"the Gram matrix of {len(states)} states is not finite")
        scale[scale == 0.0] = 1.0
        with np.errstate(all="ignore"):  # above the diagonal lies what memory held before
            gram /= scale[:, None]
            gram /= scale
        # The lower triangle of a row-major matrix is the upper one of its transpose: no copy.
        upper, order, rank, _ = lapack.dpstrf(gram.T, tol=FOLLOWS, lower=0, overwrite_a=1)
        pivots = np.asarray(order[:rank] - 1, dtype=np.int64)
        kept = np.asfortranarray(upper[:rank, :rank])
        return cls(kernel, states, joints, pivots, scale[pivots], kept)

    @property
    def size(self) -> int:
        """M, the number of features."""
        return len(self.pivots)

    def chunks(self, samples: Ints) -> Iterator[Ints]:
        """The samples in runs, so that what is held of each of them stays bounded."""
        torques = len(self.states) * len(self.joints)
        count = max(1, CHUNK_ENTRIES // (torques * len(self.joints)))
        for first in range(0, len(samples), count):
            yield samples[first : first + count]

    def cross(self, x: States) -> Floats:
        """(R n, C n) the kernel between R states and all landmarks, sample major."""
        return cross_of(self.kernel, x, self.states, self.joints)

    def features(self, x: States) -> Floats:
        """(R n, M) ψ of R states."""
        return self.features_of(self.cross(x))

    def features_of(self, cross: Floats) -> Floats:
        """(R, M) ψ of R torques, or functionals of them, for their kernel with the landmarks."""
        held = cross[:, self.pivots]
        held /= self.scale
        if not self.size:
            return held
        solved = solve_triangular(self.upper, held.T, trans=1, check_finite=False, overwrite_b=True)
        return np.asarray(solved.T)

    def variance(self, x: States) -> Floats:
        """(R n,) prior variance of the torques of R states."""
        return self.kernel.variance(x)[:, list(self.joints)].ravel()

    def weights(self, values: Floats) -> Floats:
        """(C n, K) what the kernel at the landmarks is multiplied by, for (M, K) of features."""
        out = np.zeros((len(self.states) * len(self.joints), values.shape[1]))
        if self.size:
            solved = solve_triangular(self.upper, values, check_finite=False)
            out[self.pivots] = solved / self.scale[:, None]
        return out
