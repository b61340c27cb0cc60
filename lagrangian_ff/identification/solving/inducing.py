"""Inducing points: the states that a kernel is built on, fewer than the samples learned from.

With Z the inducing points and K_ZZ = Lᵀ L, a state has the features ψ(x) = L⁻ᵀ k_Z(x), whose
products approximate the kernel by K ≈ Ψ Ψᵀ, exact at the inducing points (subset of regressors;
Quiñonero-Candela and Rasmussen, JMLR 6, 2005). The factor is a Cholesky with pivots, which drops
torques of inducing points that follow from the others.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from scipy.linalg import blas, lapack, solve_triangular

from lagrangian_ff.arrays import Floats, Ints
from lagrangian_ff.identification.problem import Rows
from lagrangian_ff.identification.solving.solution import NotPositiveDefiniteError
from lagrangian_ff.kernels import Kernel, States
from lagrangian_ff.kernels.base import CHUNK_ENTRIES
from lagrangian_ff.kernels.dense import cross_of, gram_of
from lagrangian_ff.progress import Progress, silent

FOLLOWS = 1e-12
"""A torque with less than this share of its prior variance left is not a feature."""


@dataclass(frozen=True)
class InducingPoints:
    """The inducing points of the joints that are solved together, and their factor.

    Attributes:
        kernel: of the torques.  states: (C, N).  joints: the n joints that are solved together.
        pivots: (M,) the torques, of C n, that are features.
        scale: (M,) their prior standard deviation.  upper: (M, M) L, of their correlations.
    """

    kernel: Kernel
    states: States
    joints: tuple[int, ...]
    pivots: Ints
    scale: Floats
    upper: Floats

    @classmethod
    def of(cls, kernel: Kernel, states: States, joints: tuple[int, ...]) -> "InducingPoints":
        """Factor the Gram matrix of some states.

        Raises:
            NotPositiveDefiniteError: the Gram matrix is not finite.
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
        """Return M, the number of features."""
        return len(self.pivots)

    def chunks(self, samples: Ints) -> Iterator[Ints]:
        """Yield the samples in runs, so that memory stays bounded."""
        torques = len(self.states) * len(self.joints)
        count = max(1, CHUNK_ENTRIES // (torques * len(self.joints)))
        for first in range(0, len(samples), count):
            yield samples[first : first + count]

    def cross(self, x: States) -> Floats:
        """Return (R n, C n) the kernel between R states and all inducing points, sample major."""
        return cross_of(self.kernel, x, self.states, self.joints)

    def features(self, x: States) -> Floats:
        """Return ψ of R states, (R n, M)."""
        return self.features_of(self.cross(x))

    def features_of(self, cross: Floats) -> Floats:
        """Return ψ of R torques, (R, M), from their kernel with the points (R, C n)."""
        held = cross[:, self.pivots]
        held /= self.scale
        if not self.size:
            return held
        solved = solve_triangular(self.upper, held.T, trans=1, check_finite=False, overwrite_b=True)
        return np.asarray(solved.T)

    def variance(self, x: States) -> Floats:
        """Return (R n,) the prior variance of the torques of R states."""
        return self.kernel.variance(x)[:, list(self.joints)].ravel()

    def weights(self, values: Floats) -> Floats:
        """Return kernel weights (C n, K) at the points for weights (M, K) of features."""
        out = np.zeros((len(self.states) * len(self.joints), values.shape[1]))
        if self.size:
            solved = solve_triangular(self.upper, values, check_finite=False)
            out[self.pivots] = solved / self.scale[:, None]
        return out


@dataclass(frozen=True)
class Sums:
    """Sums over a group of samples.

    Attributes:
        products: (K, K) [Ψ Φ y]ᵀ D⁻¹ [Ψ Φ y], K = M + B + 1; only the lower triangle is written.
        count: torques.  log_noise: log |D|.
        stuck: of these, torques of joints at rest.  log_stuck: their part of log |D|.
    """

    products: Floats
    count: int
    log_noise: float
    stuck: int
    log_stuck: float

    @classmethod
    def over(
        cls, points: InducingPoints, rows: Rows, samples: Ints, progress: Progress = silent
    ) -> "Sums":
        """Sum over some samples, chunk by chunk."""
        size = points.size + rows.columns.shape[1] + 1
        products = np.zeros((size, size), order="F")
        log_noise, stuck, log_stuck, done = 0.0, 0, 0.0, 0
        for chunk in points.chunks(samples):
            at = rows.of(chunk)
            features = points.features(rows.states.take(chunk))
            held = np.column_stack([features, rows.design(chunk), rows.target[at]])
            held /= np.sqrt(rows.noise[at])[:, None]
            # Accumulated in place, half of the work of a product.
            products = blas.dsyrk(1.0, held.T, beta=1.0, c=products, lower=1, overwrite_c=1)
            logs, rests = np.log(rows.noise[at]), rows.stuck[at]
            log_noise += float(np.sum(logs))
            stuck += int(np.sum(rests))
            log_stuck += float(np.sum(logs[rests]))
            done += len(chunk)
            progress(done / len(samples), "summing over the samples")
        return cls(products, len(samples) * len(points.joints), log_noise, stuck, log_stuck)

    def plus(self, other: "Sums", sign: float = 1.0) -> "Sums":
        """Return the sum with another group, or, for sign −1, without it."""
        return Sums(
            self.products + sign * other.products,
            self.count + int(sign) * other.count,
            self.log_noise + sign * other.log_noise,
            self.stuck + int(sign) * other.stuck,
            self.log_stuck + sign * other.log_stuck,
        )

    def squares_left(self, theta: Floats) -> float:
        """Return the squares of y − Ψ w − Φ b over the noise, for theta (K,) = (−w, −b, 1)."""
        return float(theta @ blas.dsymv(1.0, self.products, theta, lower=1))
