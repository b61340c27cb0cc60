"""The linear algebra of a model on inducing points: everything follows from sums over the samples.

With features Ψ (see `inducing`), noise variances D and a factor f on them, G = Ψ Ψᵀ + f D, and

    A = I + Ψᵀ D⁻¹ Ψ / f,    G⁻¹ = (D⁻¹ − D⁻¹ Ψ A⁻¹ Ψᵀ D⁻¹ / f) / f,    |G| = |A| |f D|,

so that b, a, the evidence and the residuals of any group left out follow from
[Ψ Φ y]ᵀ D⁻¹ [Ψ Φ y], summed over the samples, and from the same sum over the group. Beside the
samples themselves, memory does not grow with them, and time grows in proportion.

The variance of a torque: what the points cannot express keeps its prior variance (as in FITC,
Snelson and Ghahramani 2006, Advances in Neural Information Processing Systems 18), and the features
have the posterior A⁻¹. f is the number of neighbouring samples with a common error: f of them count
as one, which multiplies their variance by f and leaves the noise of a single one as it was.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property, reduce

import numpy as np
from scipy.linalg import cholesky, solve_triangular

from lagrangian_ff.arrays import Floats, Ints
from lagrangian_ff.identification.problem import Rows
from lagrangian_ff.identification.samples import evenly
from lagrangian_ff.identification.solving.inducing import InducingPoints, Sums
from lagrangian_ff.identification.solving.solution import (
    LeftOut,
    NotPositiveDefiniteError,
    Pulled,
    Solution,
)
from lagrangian_ff.progress import Progress, part, silent

LOOKED = 400
"""Samples of a group left out whose variance is computed."""
HIDDEN = 1e-12
"""Share of a column outside the features' span below which it is rounding."""


@dataclass(frozen=True)
class Reduced(Solution):
    """The solution that follows from sums alone, without the samples.

    Attributes:
        sums: over all samples that are learned from.
        points: of the features.  factor: f, on the noise.
    """

    sums: Sums
    points: InducingPoints
    factor: float

    @property
    def count(self) -> int:
        return self.sums.count

    @property
    def at_rest(self) -> tuple[int, float]:
        stuck, log_stuck = self.sums.stuck, self.sums.log_stuck
        return stuck, log_stuck + stuck * float(np.log(self.factor))

    @cached_property
    def _lower(self) -> Floats:
        """Return the Cholesky factor of A, (M, M)."""
        size = self.points.size
        inner = self.sums.products[:size, :size] / self.factor
        inner[np.diag_indices(size)] += 1.0
        try:
            return np.asarray(cholesky(inner, lower=True, check_finite=False, overwrite_a=True))
        except np.linalg.LinAlgError as error:
            raise NotPositiveDefiniteError(f"the features have no factor: {error}") from error

    @cached_property
    def _white(self) -> Floats:
        """Return (M, B + 1) Ψᵀ D⁻¹ [Φ y] / f, whitened with A."""
        size = self.points.size
        right = self.sums.products[size:, :size].T / self.factor
        return _solve(self._lower, right, trans=0)

    @cached_property
    def _schur(self) -> Floats:
        """Return (B + 1, B + 1) [Φ y]ᵀ G⁻¹ [Φ y]."""
        size = self.points.size
        corner = self.sums.products[size:, size:] / self.factor
        corner = np.tril(corner) + np.tril(corner, -1).T
        left = corner - self._white.T @ self._white
        hidden = np.flatnonzero(np.diag(left)[:-1] <= HIDDEN * np.diag(corner)[:-1])
        left[hidden, :], left[:, hidden] = 0.0, 0.0
        return np.asarray(left)

    @property
    def information(self) -> Floats:
        return np.asarray(self._schur[:-1, :-1])

    @property
    def moment(self) -> Floats:
        return np.asarray(self._schur[:-1, -1])

    @property
    def squares(self) -> float:
        return max(0.0, float(self._schur[-1, -1] - self.moment @ self.coefficients))

    @property
    def log_det(self) -> float:
        inner = 2.0 * float(np.sum(np.log(np.diag(self._lower))))
        return inner + self.sums.log_noise + self.count * float(np.log(self.factor))

    @cached_property
    def feature_weights(self) -> Floats:
        """Return (M, B + 1) A⁻¹ Ψᵀ D⁻¹ [Φ y] / f, the weights of the features for each column."""
        return _solve(self._lower, self._white, trans=1)

    @cached_property
    def theta(self) -> Floats:
        """Return (−w, −b, 1), (K,), with which [Ψ Φ y] give the residuals."""
        own = np.concatenate([-self.coefficients, [1.0]])
        return np.concatenate([-self.feature_weights @ own, own])

    @property
    def weights(self) -> Floats:
        return self.points.weights(-self.theta[: self.points.size, None])[:, 0]

    @property
    def prior_amplitude(self) -> float:
        return self.factor * self.amplitude

    def variance(self, cross: Floats, design: Floats) -> tuple[Floats, Floats]:
        features, white, left = self._reduced(cross, design)
        known = np.sum(features**2, axis=1) - np.sum(white**2, axis=0)
        return np.asarray(known), np.asarray(np.sum((left @ self.covariance) * left, axis=1))

    def pulled(self, prior: Floats, cross: Floats, design: Floats) -> Pulled:
        features, white, left = self._reduced(cross, design)
        across = self.covariance @ left.T

        def moved(pull: Floats) -> tuple[Floats, Floats]:
            seen = _solve(self._lower, white @ pull, trans=1) - features.T @ pull
            seen -= self.feature_weights[:, :-1] @ (across @ pull)
            return self.points.weights(seen[:, None])[:, 0], np.asarray(across @ pull)

        return Pulled(prior - features @ features.T + white.T @ white + left @ across, moved)

    def _reduced(self, cross: Floats, design: Floats) -> tuple[Floats, Floats, Floats]:
        """Return features (R, M), these whitened (M, R), and the basis less their part (R, B)."""
        features = self.points.features_of(cross.T)
        white = _solve(self._lower, features.T, trans=0)
        return features, white, design - features @ self.feature_weights[:, :-1]

    def without(self, part: Sums) -> "Reduced":
        """Return the solution without a part of the samples."""
        return Reduced(self.sums.plus(part, -1.0), self.points, self.factor)


@dataclass(frozen=True)
class LowRank(Reduced):
    """The solution on inducing points, with all samples.

    Attributes:
        rows: of all samples.
        groups: samples that are left out together; every sample in one of them.
        parts: the sum over each group.
    """

    rows: Rows
    groups: tuple[Ints, ...]
    parts: tuple[Sums, ...]

    @classmethod
    def of(
        cls, points: InducingPoints, rows: Rows, groups: Sequence[Ints], progress: Progress = silent
    ) -> "LowRank":
        """Sum over all samples, group by group.

        Args:
            progress: receives the share done, 0 to 1.
        """
        parts = []
        for number, group in enumerate(groups):
            share = part(progress, number / len(groups), (number + 1) / len(groups))
            parts.append(Sums.over(points, rows, group, share))
        total = reduce(Sums.plus, parts[1:], parts[0])
        return cls(total, points, 1.0, rows, tuple(groups), tuple(parts))

    @property
    def error_left_out(self) -> float:
        """Return the mean square over the noise of groups left out in turn."""
        squares = (one.squares_left(self.without(one).theta) for one in self.parts)
        return sum(squares) / self.count

    def left_out(self, groups: Sequence[Ints]) -> Iterator[LeftOut]:
        """Yield the residuals of groups that were summed; see `System.left_out`."""
        for rows in groups:
            yield self._left[self._number(rows)]

    def left_out_variance(self, groups: Sequence[Ints]) -> Iterator[Floats]:
        """Yield the variance of some rows of each group, else NaN; see `System`."""
        for rows in groups:
            number = self._number(rows)
            samples, without = self.groups[number], self.without(self.parts[number])
            found = np.full((len(samples), len(self.points.joints)), np.nan)
            for chunk in self.points.chunks(evenly(len(samples), LOOKED)):
                x, at = self.rows.states.take(samples[chunk]), self.rows.of(samples[chunk])
                cross, design = self.points.cross(x), self.rows.design(samples[chunk])
                known, added = without.variance(cross.T, design)
                left = np.maximum(self.points.variance(x) - known, 0.0)
                whole = self.factor * (left + added + self.rows.noise[at])
                found[chunk] = whole.reshape(len(chunk), -1)
            yield found.ravel()

    def _number(self, rows: Ints) -> int:
        """Return the number of the group with these rows."""
        for number, samples in enumerate(self.groups):
            if np.array_equal(self.rows.of(samples), rows):
                return number
        raise ValueError("only the groups that were summed can be left out")

    @cached_property
    def _left(self) -> tuple[LeftOut, ...]:
        return tuple(map(self._without_seeing, self.groups, self.parts))

    def _without_seeing(self, samples: Ints, part: Sums) -> LeftOut:
        without = self.without(part)
        residual = self._residual(samples, without.weights, without.coefficients)
        change = without.coefficients - self.coefficients
        return LeftOut(self.rows.of(samples), residual, change)

    @cached_property
    def residual(self) -> Floats:
        """Return (n,) torque minus prediction."""
        return self._residual(np.arange(len(self.rows.states)), self.weights, self.coefficients)

    def _residual(self, samples: Ints, weights: Floats, coefficients: Floats) -> Floats:
        """Return (R n,) the torques of some samples, less those of a model on the points."""
        left, first = self.rows.target[self.rows.of(samples)], 0
        for chunk in self.points.chunks(samples):
            cross = self.points.cross(self.rows.states.take(chunk))
            here = slice(first, first + len(cross))
            left[here] -= cross @ weights + self.rows.design(chunk) @ coefficients
            first = here.stop
        return left

    def changes(self, groups: Sequence[Ints]) -> Floats:
        """Return (G, B) the change of the coefficients when each group of rows is left out.

        To first order it is −(Φᵀ G⁻¹ Φ)⁻¹ (G⁻¹ Φ)ᵀ r over the rows of the group, with r their
        residuals when their whole part is left out, hardly larger than for the group alone.
        """
        label = np.full(self.count, -1)
        for number, group in enumerate(groups):
            label[group] = number
        sums = np.zeros((len(groups) + 1, self.rows.columns.shape[1]))  # the last is for no group
        explained = self.points.weights(self.feature_weights[:, :-1])
        pull = np.empty(self.count)
        for left in self._left:
            pull[left.rows] = left.residual / (self.factor * self.rows.noise[left.rows])
        for chunk in self.points.chunks(np.arange(len(self.rows.states))):
            rows = self.rows.of(chunk)
            cross = self.points.cross(self.rows.states.take(chunk))
            own = self.rows.design(chunk) - cross @ explained
            np.add.at(sums, label[rows], own * pull[rows, None])
        return -sums[:-1] @ self.covariance


def _solve(lower: Floats, right: Floats, trans: int) -> Floats:
    if not len(lower):
        return right
    return np.asarray(solve_triangular(lower, right, lower=True, trans=trans, check_finite=False))
