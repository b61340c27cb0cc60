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
from numpy.typing import NDArray
from scipy.linalg import lapack, solve_triangular

from lagrangian_ff.identification.solving.solution import (
    LeftOut,
    NotPositiveDefiniteError,
    Pulled,
    Solution,
)

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


@dataclass(frozen=True)
class System(Solution):
    """The factor of G and all that was whitened with it.

    Attributes:
        upper: (n, n) U with Uᵀ U = G, n = samples × joints of this system.
        design: (n, B) the basis Φ.
        target: (n,) the torques y.
        noise: (n,) variance of each, D.
        white_design: (n, B) U⁻ᵀ Φ.
        white_target: (n,) U⁻ᵀ y.
    """

    upper: Floats
    design: Floats
    target: Floats
    noise: Floats
    white_design: Floats
    white_target: Floats

    @classmethod
    def factor(cls, gram: Floats, noise: Floats, design: Floats, target: Floats) -> "System":
        """Add the noise to the Gram matrix, factor it in place, and whiten basis and torques.

        Args:
            gram: (n, n), C-contiguous, lower triangle used; overwritten.
            noise: (n,) variance of each torque.
            design: (n, B).
            target: (n,).

        Raises:
            NotPositiveDefiniteError: rounding left a pivot that is not positive, or the Gram matrix
                is not finite.
        """
        size = gram.shape[0]
        gram.flat[:: size + 1] += noise
        # The lower triangle of a row-major matrix is the upper one of its transpose: no copy.
        upper, info = lapack.dpotrf(gram.T, lower=0, clean=0, overwrite_a=1)
        if info != 0:
            raise NotPositiveDefiniteError(f"pivot {info} of {size} is not positive")
        if not np.isfinite(np.diag(upper)).all():  # which the factorisation need not notice
            raise NotPositiveDefiniteError(f"the Gram matrix of {size} torques is not finite")
        return cls._whitened(upper, design, target, noise)

    def of(self, design: Floats, target: Floats) -> "System":
        """The system of the same Gram matrix and noise with another basis and other torques."""
        return self._whitened(self.upper, design, target, self.noise)

    @classmethod
    def _whitened(cls, upper: Floats, design: Floats, target: Floats, noise: Floats) -> "System":
        white = solve_triangular(
            upper, np.column_stack([design, target]), trans=1, check_finite=False
        )
        return cls(upper, design, target, noise, white[:, :-1], white[:, -1])

    @cached_property
    def information(self) -> Floats:
        """(B, B) Φᵀ G⁻¹ Φ."""
        return self.white_design.T @ self.white_design

    @property
    def count(self) -> int:
        """n, the number of torques."""
        return int(self.design.shape[0])

    @cached_property
    def moment(self) -> Floats:
        """(B,) Φᵀ G⁻¹ y."""
        return np.asarray(self.white_design.T @ self.white_target)

    @cached_property
    def _white_residual(self) -> Floats:
        return np.asarray(self.white_target - self.white_design @ self.coefficients)

    @cached_property
    def weights(self) -> Floats:
        """(n,) a = P y, what the kernel is multiplied by."""
        return np.asarray(solve_triangular(self.upper, self._white_residual, check_finite=False))

    @property
    def residual(self) -> Floats:
        """(n,) torque minus what is predicted for it: the noise times a."""
        return self.noise * self.weights

    @property
    def squares(self) -> float:
        """See `Solution.squares`."""
        return float(self._white_residual @ self._white_residual)

    @property
    def log_det(self) -> float:
        """log |G|."""
        return 2.0 * float(np.sum(np.log(np.diag(self.upper))))

    def slope_by_gram(self) -> Floats:
        """(n, n) −2 ∂/∂G of the log evidence, P − a aᵀ / s²; the lower triangle is written."""
        upper, info = lapack.dpotri(self.upper, lower=0)
        if info != 0:
            raise NotPositiveDefiniteError(f"pivot {info} is zero")
        slope = np.asarray(upper.T)
        white = self._unwhitened_design
        with np.errstate(all="ignore"):  # what memory held above the diagonal
            slope -= white @ self.covariance @ white.T
            slope -= np.outer(self.weights, self.weights / self.amplitude)
        return slope

    def slope_by_design(self) -> Floats:
        """(n, B) −∂/∂Φ of the log evidence, G⁻¹ Φ (Φᵀ G⁻¹ Φ)⁻¹ − a bᵀ / s²."""
        moved = np.outer(self.weights, self.coefficients / self.amplitude)
        return np.asarray(self._unwhitened_design @ self.covariance - moved)

    @cached_property
    def _inverse_upper(self) -> Floats:
        inverse, info = lapack.dtrtri(self.upper, lower=0)
        if info != 0:
            raise NotPositiveDefiniteError(f"pivot {info} is zero")
        return np.asarray(inverse)

    @cached_property
    def _unwhitened_design(self) -> Floats:
        return np.asarray(solve_triangular(self.upper, self.white_design, check_finite=False))

    def left_out(self, groups: Sequence[Ints]) -> Iterator[LeftOut]:
        """What each group of rows would meet had the fit not seen it, from the one factor.

        Args:
            groups: for each, the rows left out together.
        """
        white, covariance = self._unwhitened_design, self.covariance
        for rows in groups:
            residual = np.linalg.solve(self._projected(rows), self.weights[rows])
            change = np.asarray(-covariance @ (white[rows].T @ residual))
            yield LeftOut(rows, np.asarray(residual, dtype=np.float64), change)

    def left_out_variance(self, groups: Sequence[Ints]) -> Iterator[Floats]:
        """(R,) for each group the variance over s² of its residuals; see `left_out`.

        Infinite where the other rows leave the basis open.
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
        """(R, R) P_ff, whose inverse is the covariance over s² of what these rows leave."""
        # U⁻¹ is upper triangular: its rows reach no column before the first of the group, and
        # what memory holds below its diagonal, NaN perhaps, must not be multiplied with.
        first = int(rows.min())
        inside = np.arange(first, self.upper.shape[0])[None, :] >= rows[:, None]
        half = np.where(inside, self._inverse_upper[rows, first:], 0.0)
        white = self._unwhitened_design[rows]
        return np.asarray(half @ half.T - white @ self.covariance @ white.T)

    def variance(self, cross: Floats, design: Floats) -> tuple[Floats, Floats]:
        """See `Solution.variance`."""
        white, left = self._met(cross, design)
        added = np.sum((left @ self.covariance) * left, axis=1)
        return np.asarray(np.sum(white**2, axis=0)), np.asarray(added)

    def pulled(self, prior: Floats, cross: Floats, design: Floats) -> Pulled:
        """See `Solution.pulled`."""
        white, left = self._met(cross, design)
        across = self.covariance @ left.T

        def moved(pull: Floats) -> tuple[Floats, Floats]:
            change = white @ pull + self.white_design @ (across @ pull)
            weights = -solve_triangular(self.upper, change, check_finite=False)
            return np.asarray(weights), np.asarray(across @ pull)

        return Pulled(prior - white.T @ white + left @ across, moved)

    def _met(self, cross: Floats, design: Floats) -> tuple[Floats, Floats]:
        """(n, R) whitened kernel, and (R, B) what it leaves of the basis, of R torques."""
        white = solve_triangular(self.upper, cross, trans=1, check_finite=False)
        return white, design - white.T @ self.white_design

    def changes(self, groups: Sequence[Ints]) -> Floats:
        """(G, B) how far the basis coefficients move when each group of rows is left out."""
        moved = [left.change for left in self.left_out(groups)]
        return np.array(moved).reshape(len(groups), self.design.shape[1])

    def weights_without(self, left: Sequence[LeftOut]) -> Floats:
        """(n, G) the weights of the fits that did not see a group, one column for each of G.

        Such a fit is that of all rows where those left out have the torque it predicts for them.
        """
        shift = np.zeros((self.upper.shape[0], len(left)))
        for column, one in enumerate(left):
            shift[one.rows, column] = one.residual
        white = solve_triangular(self.upper, shift, trans=1, check_finite=False)
        white -= self.white_design @ (self.covariance @ (self.white_design.T @ white))
        back = solve_triangular(self.upper, white, check_finite=False, overwrite_b=True)
        return np.asarray(self.weights[:, None] - back)
