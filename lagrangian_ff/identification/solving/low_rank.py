"""The linear algebra of a model on landmarks: everything follows from sums over the samples.

With features Ψ (see `landmarks`), noise variances D and a factor f on them, G = Ψ Ψᵀ + f D, and

    A = I + Ψᵀ D⁻¹ Ψ / f,    G⁻¹ = (D⁻¹ − D⁻¹ Ψ A⁻¹ Ψᵀ D⁻¹ / f) / f,    |G| = |A| |f D|,

so that b, a, the evidence and what any group of samples would meet without being seen follow from
[Ψ Φ y]ᵀ D⁻¹ [Ψ Φ y], summed over the samples, and from the same sum over the group. Beside the
samples themselves, memory does not grow with them, and time does in proportion.

How sure it is of a torque: what the landmarks cannot express keeps its prior variance (as in FITC,
Snelson and Ghahramani 2006, Advances in Neural Information Processing Systems 18), and the features
have the posterior A⁻¹. f counts the samples that err alike: f of them say as much as one, so that
what they tell is f times as uncertain, and the noise of a single one is as it was.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property, reduce

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import cholesky, solve_triangular

from lagrangian_ff.identification.samples import evenly
from lagrangian_ff.identification.solving.landmarks import Landmarks
from lagrangian_ff.identification.solving.rows import Rows
from lagrangian_ff.identification.solving.solution import (
    LeftOut,
    NotPositiveDefiniteError,
    Pulled,
    Solution,
)
from lagrangian_ff.identification.solving.sums import Sums
from lagrangian_ff.progress import Progress, part, silent

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

LOOKED = 400
"""Of a group left out, how many samples tell how sure the model would have been of it."""
HIDDEN = 1e-12
"""Share of a column that must not be in the features' span to be told from rounding."""


@dataclass(frozen=True)
class Reduced(Solution):
    """The model that sums ask for, which knows no samples.

    Attributes:
        sums: over all samples that are learned from.
        landmarks: what the features are of.
        factor: f, what the noise is multiplied by.
    """

    sums: Sums
    landmarks: Landmarks
    factor: float

    @property
    def count(self) -> int:
        """See `Solution.count`."""
        return self.sums.count

    @cached_property
    def _lower(self) -> Floats:
        """(M, M) the factor of A."""
        size = self.landmarks.size
        inner = self.sums.products[:size, :size] / self.factor
        inner[np.diag_indices(size)] += 1.0
        try:
            return np.asarray(cholesky(inner, lower=True, check_finite=False, overwrite_a=True))
        except np.linalg.LinAlgError as error:
            raise NotPositiveDefiniteError(f"the features have no factor: {error}") from error

    @cached_property
    def _white(self) -> Floats:
        """(M, B + 1) Ψᵀ D⁻¹ [Φ y] / f, whitened with A."""
        size = self.landmarks.size
        right = self.sums.products[size:, :size].T / self.factor
        return _solve(self._lower, right, trans=0)

    @cached_property
    def _schur(self) -> Floats:
        """(B + 1, B + 1) [Φ y]ᵀ G⁻¹ [Φ y]."""
        size = self.landmarks.size
        corner = self.sums.products[size:, size:] / self.factor
        corner = np.tril(corner) + np.tril(corner, -1).T
        left = corner - self._white.T @ self._white
        hidden = np.flatnonzero(np.diag(left)[:-1] <= HIDDEN * np.diag(corner)[:-1])
        left[hidden, :], left[:, hidden] = 0.0, 0.0
        return np.asarray(left)

    @property
    def information(self) -> Floats:
        """See `Solution.information`."""
        return np.asarray(self._schur[:-1, :-1])

    @property
    def moment(self) -> Floats:
        """See `Solution.moment`."""
        return np.asarray(self._schur[:-1, -1])

    @property
    def squares(self) -> float:
        """See `Solution.squares`."""
        return max(0.0, float(self._schur[-1, -1] - self.moment @ self.coefficients))

    @property
    def log_det(self) -> float:
        """See `Solution.log_det`."""
        inner = 2.0 * float(np.sum(np.log(np.diag(self._lower))))
        return inner + self.sums.log_noise + self.count * float(np.log(self.factor))

    @cached_property
    def feature_weights(self) -> Floats:
        """(M, B + 1) what the features explain of each column of [Φ y], A⁻¹ Ψᵀ D⁻¹ [Φ y] / f."""
        return _solve(self._lower, self._white, trans=1)

    @cached_property
    def theta(self) -> Floats:
        """(K,) (−w, −b, 1): by it [Ψ Φ y] become what is left of the torques."""
        own = np.concatenate([-self.coefficients, [1.0]])
        return np.concatenate([-self.feature_weights @ own, own])

    @property
    def weights(self) -> Floats:
        """See `Solution.weights`."""
        return self.landmarks.weights(-self.theta[: self.landmarks.size, None])[:, 0]

    @property
    def prior_amplitude(self) -> float:
        """See `Solution.prior_amplitude`."""
        return self.factor * self.amplitude

    def variance(self, cross: Floats, design: Floats) -> tuple[Floats, Floats]:
        """See `Solution.variance`."""
        features, white, left = self._met(cross, design)
        known = np.sum(features**2, axis=1) - np.sum(white**2, axis=0)
        return np.asarray(known), np.asarray(np.sum((left @ self.covariance) * left, axis=1))

    def pulled(self, prior: Floats, cross: Floats, design: Floats) -> Pulled:
        """See `Solution.pulled`."""
        features, white, left = self._met(cross, design)
        across = self.covariance @ left.T

        def moved(pull: Floats) -> tuple[Floats, Floats]:
            seen = _solve(self._lower, white @ pull, trans=1) - features.T @ pull
            seen -= self.feature_weights[:, :-1] @ (across @ pull)
            return self.landmarks.weights(seen[:, None])[:, 0], np.asarray(across @ pull)

        return Pulled(prior - features @ features.T + white.T @ white + left @ across, moved)

    def _met(self, cross: Floats, design: Floats) -> tuple[Floats, Floats, Floats]:
        """(R, M) features, (M, R) these whitened, (R, B) what they leave of the basis."""
        features = self.landmarks.features_of(cross.T)
        white = _solve(self._lower, features.T, trans=0)
        return features, white, design - features @ self.feature_weights[:, :-1]

    def without(self, part: Sums) -> "Reduced":
        """The model of all samples but a part of them."""
        return Reduced(self.sums.plus(part, -1.0), self.landmarks, self.factor)


@dataclass(frozen=True)
class LowRank(Reduced):
    """The model on landmarks, with all it was learned from.

    Attributes:
        rows: all that is learned from.
        groups: samples that are left out together; every sample in one of them.
        parts: the sum over each group.
    """

    rows: Rows
    groups: tuple[Ints, ...]
    parts: tuple[Sums, ...]

    @classmethod
    def of(
        cls,
        landmarks: Landmarks,
        rows: Rows,
        groups: Sequence[Ints],
        progress: Progress = silent,
    ) -> "LowRank":
        """Sum over all samples, group by group.

        Args:
            landmarks: of the system.
            rows: all that is learned from.
            groups: samples that are left out together; every sample in one of them.
            progress: told the share done.
        """
        parts = []
        for number, group in enumerate(groups):
            share = part(progress, number / len(groups), (number + 1) / len(groups))
            parts.append(Sums.over(landmarks, rows, group, share))
        total = reduce(Sums.plus, parts[1:], parts[0])
        return cls(total, landmarks, 1.0, rows, tuple(groups), tuple(parts))

    @property
    def error_left_out(self) -> float:
        """The mean square over the noise that groups would meet, each left out in turn."""
        squares = (one.squares_left(self.without(one).theta) for one in self.parts)
        return sum(squares) / self.count

    def left_out(self, groups: Sequence[Ints]) -> Iterator[LeftOut]:
        """See `System.left_out`; of the groups that were summed, no others."""
        for rows in groups:
            yield self._left[self._number(rows)]

    def left_out_variance(self, groups: Sequence[Ints]) -> Iterator[Floats]:
        """See `System.left_out_variance`; of some rows of each group, NaN for the others."""
        for rows in groups:
            number = self._number(rows)
            samples, without = self.groups[number], self.without(self.parts[number])
            found = np.full((len(samples), len(self.landmarks.joints)), np.nan)
            for chunk in self.landmarks.chunks(evenly(len(samples), LOOKED)):
                x, at = self.rows.states.take(samples[chunk]), self.rows.of(samples[chunk])
                cross, design = self.landmarks.cross(x), self.rows.design(samples[chunk])
                known, added = without.variance(cross.T, design)
                left = np.maximum(self.landmarks.variance(x) - known, 0.0)
                whole = self.factor * (left + added + self.rows.noise[at])
                found[chunk] = whole.reshape(len(chunk), -1)
            yield found.ravel()

    def _number(self, rows: Ints) -> int:
        """Of the group with these rows."""
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
        """See `System.residual`."""
        return self._residual(np.arange(len(self.rows.states)), self.weights, self.coefficients)

    def _residual(self, samples: Ints, weights: Floats, coefficients: Floats) -> Floats:
        """(R n,) the torques of some samples, less those of a model on the landmarks."""
        left, first = self.rows.target[self.rows.of(samples)], 0
        for chunk in self.landmarks.chunks(samples):
            cross = self.landmarks.cross(self.rows.states.take(chunk))
            here = slice(first, first + len(cross))
            left[here] -= cross @ weights + self.rows.design(chunk) @ coefficients
            first = here.stop
        return left

    def changes(self, groups: Sequence[Ints]) -> Floats:
        """(G, B) how far the basis coefficients move when each group of rows is left out.

        To first order, −(Φᵀ G⁻¹ Φ)⁻¹ (G⁻¹ Φ)ᵀ r over the rows of the group, where r is what they
        meet when their whole part is left out: for small groups, hardly more than what they
        would meet alone.
        """
        label = np.full(self.count, -1)
        for number, group in enumerate(groups):
            label[group] = number
        sums = np.zeros((len(groups) + 1, self.rows.columns.shape[1]))  # the last is for no group
        explained = self.landmarks.weights(self.feature_weights[:, :-1])
        pull = np.empty(self.count)
        for left in self._left:
            pull[left.rows] = left.residual / (self.factor * self.rows.noise[left.rows])
        for chunk in self.landmarks.chunks(np.arange(len(self.rows.states))):
            rows = self.rows.of(chunk)
            cross = self.landmarks.cross(self.rows.states.take(chunk))
            own = self.rows.design(chunk) - cross @ explained
            np.add.at(sums, label[rows], own * pull[rows, None])
        return -sums[:-1] @ self.covariance


def _solve(lower: Floats, right: Floats, trans: int) -> Floats:
    if not len(lower):
        return right
    return np.asarray(solve_triangular(lower, right, lower=True, trans=trans, check_finite=False))
