"""The linear algebra of the semi-parametric model: everything follows from one Cholesky factor.

A system is the joints that are solved together: all of them for a coupled kernel, one for an
independent kernel. With the Gram matrix K, noise variances D, basis Φ and torques y, all stacked
sample major, G = K + D and

    b = (Φᵀ G⁻¹ Φ)⁻¹ Φᵀ G⁻¹ y,      a = G⁻¹ (y − Φ b) = P y,

which solves (44) exactly: the basis is not penalised. The projection

    P = G⁻¹ − G⁻¹ Φ (Φᵀ G⁻¹ Φ)⁻¹ Φᵀ G⁻¹

also gives the restricted evidence, and the residuals of samples left out, (P_ff)⁻¹ (P y)_f,
without refitting.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.linalg import blas, lapack, solve_triangular

from lagrangian_ff.arrays import Flags, Floats, Ints
from lagrangian_ff.identification.solving.solution import (
    LeftOut,
    NotPositiveDefiniteError,
    Pulled,
    Solution,
)


@dataclass(frozen=True)
class Cholesky:
    """The factor of G.

    Attributes:
        upper: (n, n) U with Uᵀ U = G, n = samples × joints of a system.
    """

    upper: Floats

    def inverted(self) -> Floats:
        """Return G⁻¹, (n, n), a new array of which the upper triangle is written."""
        inverse, info = lapack.dpotri(self.upper, lower=0)
        if info != 0:
            raise NotPositiveDefiniteError(f"pivot {info} is zero")
        return np.asarray(inverse)

    @cached_property
    def inverse(self) -> Floats:
        """Return the same, cached, to be read only."""
        return self.inverted()


@dataclass(frozen=True)
class System(Solution):
    """The exact solution: the factor of G, basis and torques whitened with it.

    Attributes:
        cholesky: the factor.
        design: (n, B) the basis Φ.  target: (n,) the torques y.  noise: (n,) variance of each, D.
        stuck: (n,) the torques of joints at rest.
        white_design: (n, B) U⁻ᵀ Φ.  white_target: (n,) U⁻ᵀ y.
    """

    cholesky: Cholesky
    design: Floats
    target: Floats
    noise: Floats
    stuck: Flags
    white_design: Floats
    white_target: Floats

    @classmethod
    def factor(
        cls, gram: Floats, noise: Floats, design: Floats, target: Floats, stuck: Flags | None = None
    ) -> "System":
        """Add the noise to the Gram matrix, factor it in place, and whiten basis and torques.

        Args:
            gram: (n, n), C-contiguous, lower triangle used; overwritten.
            noise: (n,) variance of each torque.  design: (n, B).  target: (n,).
            stuck: (n,) the torques of joints at rest; None is none.

        Raises:
            NotPositiveDefiniteError: a pivot is not positive, or the Gram matrix is not finite.
        """
        size = gram.shape[0]
        gram.flat[:: size + 1] += noise
        # The lower triangle of a row-major matrix is the upper one of its transpose: no copy.
        upper, info = lapack.dpotrf(gram.T, lower=0, clean=0, overwrite_a=1)
        if info != 0:
            raise NotPositiveDefiniteError(f"pivot {info} of {size} is not positive")
        if not np.isfinite(np.diag(upper)).all():  # LAPACK need not notice
            raise NotPositiveDefiniteError(f"the Gram matrix of {size} torques is not finite")
        stuck = np.zeros(size, dtype=np.bool_) if stuck is None else stuck
        return cls._whitened(Cholesky(upper), design, target, noise, stuck)

    def of(self, design: Floats, target: Floats) -> "System":
        """Return the system of the same Gram matrix and noise with another basis and torques."""
        return self._whitened(self.cholesky, design, target, self.noise, self.stuck)

    @classmethod
    def _whitened(
        cls, cholesky: Cholesky, design: Floats, target: Floats, noise: Floats, stuck: Flags
    ) -> "System":
        both = np.column_stack([design, target])
        white = solve_triangular(cholesky.upper, both, trans=1, check_finite=False)
        return cls(cholesky, design, target, noise, stuck, white[:, :-1], white[:, -1])

    @property
    def upper(self) -> Floats:
        """Return U, (n, n), with Uᵀ U = G, n = samples × joints of this system."""
        return self.cholesky.upper

    @cached_property
    def information(self) -> Floats:
        return self.white_design.T @ self.white_design

    @property
    def count(self) -> int:
        return int(self.design.shape[0])

    @property
    def at_rest(self) -> tuple[int, float]:
        return int(self.stuck.sum()), float(np.sum(np.log(self.noise[self.stuck])))

    @cached_property
    def moment(self) -> Floats:
        return np.asarray(self.white_design.T @ self.white_target)

    @cached_property
    def _white_residual(self) -> Floats:
        return np.asarray(self.white_target - self.white_design @ self.coefficients)

    @cached_property
    def weights(self) -> Floats:
        return np.asarray(solve_triangular(self.upper, self._white_residual, check_finite=False))

    @property
    def residual(self) -> Floats:
        """Return (n,) torque minus prediction: the noise times a."""
        return self.noise * self.weights

    @property
    def squares(self) -> float:
        return float(self._white_residual @ self._white_residual)

    @property
    def log_det(self) -> float:
        return 2.0 * float(np.sum(np.log(np.diag(self.upper))))

    def slope_by_gram(self) -> Floats:
        """Return (n, n) −2 ∂/∂G of the log evidence, P − a aᵀ / s², in the lower triangle."""
        pulled = self.weights / np.sqrt(self.amplitude)
        shift = np.column_stack([self._unwhitened_design @ self._half_covariance, pulled])
        slope = blas.dsyrk(-1.0, shift, beta=1.0, c=self.cholesky.inverted(), overwrite_c=1)
        return np.asarray(slope.T)

    def slope_by_design(self) -> Floats:
        """Return (n, B) −∂/∂Φ of the log evidence, G⁻¹ Φ (Φᵀ G⁻¹ Φ)⁻¹ − a bᵀ / s²."""
        moved = np.outer(self.weights, self.coefficients / self.amplitude)
        return np.asarray(self._unwhitened_design @ self.covariance - moved)

    @cached_property
    def _unwhitened_design(self) -> Floats:
        return np.asarray(solve_triangular(self.upper, self.white_design, check_finite=False))

    def left_out(self, groups: Sequence[Ints]) -> Iterator[LeftOut]:
        """Yield the residuals of each group of rows left out, from the one factor.

        Args:
            groups: rows that are left out together.
        """
        white, covariance = self._unwhitened_design, self.covariance
        for rows in groups:
            residual = np.linalg.solve(self._projected(rows), self.weights[rows])
            change = np.asarray(-covariance @ (white[rows].T @ residual))
            yield LeftOut(rows, np.asarray(residual, dtype=np.float64), change)

    def left_out_variance(self, groups: Sequence[Ints]) -> Iterator[Floats]:
        """Yield (R,) for each group, the variance over s² of its residuals; see `left_out`.

        It is infinite if the other rows do not determine the basis.
        """
        for rows in groups:
            try:
                half = np.linalg.cholesky(self._projected(rows))
            except np.linalg.LinAlgError:
                yield np.full(len(rows), np.inf)
                continue
            inverse = solve_triangular(half, np.eye(len(half)), lower=True, check_finite=False)
            yield np.asarray(np.sum(inverse**2, axis=0))

    def _projected(self, rows: Ints) -> Floats:
        """Return P_ff, (R, R), whose inverse is the covariance over s² of these rows left out."""
        white = self._unwhitened_design[rows] @ self._half_covariance
        return self._inverse(rows) - np.asarray(white @ white.T)

    def _inverse(self, rows: Ints) -> Floats:
        """Return (G⁻¹)_ff, (R, R)."""
        first, second = np.minimum.outer(rows, rows), np.maximum.outer(rows, rows)
        return np.asarray(self.cholesky.inverse[first, second])

    def seen_by(self, rows: Ints, known: Floats) -> tuple[Floats, Floats, float]:
        """Return the reduced least-squares problem of columns that act on some rows only.

        Columns c, (R, P) in these rows, become U c, with which the squares fall by those of the
        part of t that U c spans.

        Args:
            rows: (R,) of the columns.
            known: (n, K) whitened columns, orthonormal, that are fitted first.

        Returns:
            (R, R) U, (R,) t, and the squares that the known columns leave.

        Raises:
            LinAlgError: rounding leaves no U.
        """
        left = self.white_target - known @ (known.T @ self.white_target)
        both = np.column_stack([known, left])
        back = solve_triangular(self.upper, both, check_finite=False)[rows]
        lower = np.linalg.cholesky(self._inverse(rows) - back[:, :-1] @ back[:, :-1].T)
        target = solve_triangular(lower, back[:, -1], lower=True, check_finite=False)
        return np.asarray(lower.T), np.asarray(target), float(left @ left)

    def variance(self, cross: Floats, design: Floats) -> tuple[Floats, Floats]:
        white, left = self._reduced(cross, design)
        added = np.sum((left @ self.covariance) * left, axis=1)
        return np.asarray(np.sum(white**2, axis=0)), np.asarray(added)

    def pulled(self, prior: Floats, cross: Floats, design: Floats) -> Pulled:
        white, left = self._reduced(cross, design)
        across = self.covariance @ left.T

        def moved(pull: Floats) -> tuple[Floats, Floats]:
            change = white @ pull + self.white_design @ (across @ pull)
            weights = -solve_triangular(self.upper, change, check_finite=False)
            return np.asarray(weights), np.asarray(across @ pull)

        return Pulled(prior - white.T @ white + left @ across, moved)

    def _reduced(self, cross: Floats, design: Floats) -> tuple[Floats, Floats]:
        """Return the whitened kernel (n, R) of R torques, and the basis less its part (R, B)."""
        white = solve_triangular(self.upper, cross, trans=1, check_finite=False)
        return white, design - white.T @ self.white_design

    def changes(self, groups: Sequence[Ints]) -> Floats:
        """Return (G, B) the change of the coefficients when each group of rows is left out."""
        moved = [left.change for left in self.left_out(groups)]
        return np.array(moved).reshape(len(groups), self.design.shape[1])

    def weights_without(self, left: Sequence[LeftOut]) -> Floats:
        """Return (n, G) the weights of the fits without each of G groups, one column for each.

        Such a fit is that of all rows with the left-out torques replaced by its predictions.
        """
        shift = np.zeros((self.upper.shape[0], len(left)))
        for column, one in enumerate(left):
            shift[one.rows, column] = one.residual
        white = solve_triangular(self.upper, shift, trans=1, check_finite=False)
        white -= self.white_design @ (self.covariance @ (self.white_design.T @ white))
        back = solve_triangular(self.upper, white, check_finite=False, overwrite_b=True)
        return np.asarray(self.weights[:, None] - back)
