"""The solution of a semi-parametric model, exact or on inducing points.

With G the covariance of n torques y and Φ their basis, everything here follows from Φᵀ G⁻¹ Φ,
Φᵀ G⁻¹ y, yᵀ P y and log |G|; see `system` for P.
"""

from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import TypeVar

import numpy as np

from lagrangian_ff.arrays import Floats, Ints
from lagrangian_ff.errors import ModelError

Made = TypeVar("Made")

UNSEEN = 1e-11
"""Share of the largest eigenvalue of the scaled information that counts as zero."""

DUST = 1e-75
"""Size of a column over its noise that counts as zero: the inverse of its square overflows."""


STRONGER = 10.0 ** np.arange(7)
"""Factors on too little noise, tried in turn until there is a Cholesky factor."""


class NotPositiveDefiniteError(ArithmeticError):
    """The regularised Gram matrix has no Cholesky factor: more regularisation is needed."""


def with_least_noise(attempt: Callable[[float], Made]) -> tuple[Made, float]:
    """Return the result of the least noise with which an attempt succeeds, and its factor.

    Args:
        attempt: solves with a factor on the noise.

    Raises:
        NotPositiveDefiniteError: there is no Cholesky factor even with much more noise.
    """
    for factor in STRONGER:
        try:
            return attempt(float(factor)), float(factor)
        except NotPositiveDefiniteError as error:
            last = str(error)
    raise NotPositiveDefiniteError(f"no factor with {STRONGER[-1]:g} times the noise: {last}")


def no_factor(what: str, qd: Floats, qdd: Floats) -> ModelError:
    """Return the error for people where `with_least_noise` fails.

    Args:
        what: the Gram matrix is of.  qd, qdd: (S, N) of its samples, in rad/s and rad/s².
    """
    speed, acceleration = np.abs(qd).max(), np.abs(qdd).max()
    return ModelError(
        f"the Gram matrix of {what} has no Cholesky factor even with {STRONGER[-1]:g} times the "
        "chosen noise: look for impossible velocities and accelerations in the recording (up to "
        f"{speed:.3g} rad/s and {acceleration:.3g} rad/s² here), or use fewer samples or "
        "--selection validation"
    )


@dataclass(frozen=True)
class LeftOut:
    """A group of rows that is left out.

    Attributes:
        rows: (R,) of the group.
        residual: (R,) their torque minus the prediction of a fit to all other rows.
        change: (B,) of the coefficients when these rows are left out.
    """

    rows: Ints
    residual: Floats
    change: Floats


@dataclass(frozen=True)
class Pulled:
    """The response of a solution to multipliers on functionals of its torque.

    Attributes:
        covariance: (R, R) posterior covariance of the functionals, over s².
        moved: returns, for multipliers (R,), the changes of the weights (C n,) and of the
            coefficients (B,); besides, the kernel of each functional joins the sum, multiplied.
    """

    covariance: Floats
    moved: Callable[[Floats], tuple[Floats, Floats]]


class Solution(ABC):
    """The torques of the joints that are solved together, solved."""

    @property
    @abstractmethod
    def count(self) -> int:
        """Return n, the number of torques."""

    @property
    @abstractmethod
    def at_rest(self) -> tuple[int, float]:
        """Return the number of torques of joints at rest, and the sum of the logs of their noise.

        These hardly count in the fit, and not in what it says of the noise.
        """

    @property
    @abstractmethod
    def information(self) -> Floats:
        """Return (B, B) Φᵀ G⁻¹ Φ."""

    @property
    @abstractmethod
    def moment(self) -> Floats:
        """Return (B,) Φᵀ G⁻¹ y."""

    @property
    @abstractmethod
    def squares(self) -> float:
        """Return the whitened squares of the residual, yᵀ P y."""

    @property
    @abstractmethod
    def log_det(self) -> float:
        """Return log |G|."""

    @property
    @abstractmethod
    def weights(self) -> Floats:
        """Return (C n,) the weights of the kernel at the model's centres."""

    @abstractmethod
    def variance(self, cross: Floats, design: Floats) -> tuple[Floats, Floats]:
        """Return how much of a torque's variance the data explain, over s².

        Args:
            cross: (C n, R) kernel between the model's centres and R torques.
            design: (R, B) the basis there.

        Returns:
            (R,) the fall of the kernel's prior variance, and (R,) the variance that the basis adds.
        """

    @abstractmethod
    def pulled(self, prior: Floats, cross: Floats, design: Floats) -> Pulled:
        """Return the response to multipliers on R functionals of the torque.

        Args:
            prior: (R, R) their kernel.
            cross: (C n, R) kernel between the model's centres and them.
            design: (R, B) the basis there.
        """

    @cached_property
    def _half_covariance(self) -> Floats:
        """Return H, (B, seen), with H Hᵀ the covariance; unobservable directions get no weight."""
        scale = np.sqrt(np.diag(self.information))
        scale[scale < DUST] = 1.0
        values, vectors = np.linalg.eigh(self.information / np.outer(scale, scale))
        seen = values > values.max(initial=0.0) * UNSEEN
        return np.asarray(vectors[:, seen] / np.sqrt(values[seen]) / scale[:, None])

    @cached_property
    def covariance(self) -> Floats:
        """Return (B, B) the inverse of the information."""
        return np.asarray(self._half_covariance @ self._half_covariance.T)

    @cached_property
    def coefficients(self) -> Floats:
        """Return b, (B,), the coefficients of the basis."""
        return np.asarray(self.covariance @ self.moment)

    @cached_property
    def degrees(self) -> int:
        """Return the number of torques minus the directions of the basis that they determine.

        Those of joints at rest are not among them.
        """
        moving = self.count - self.at_rest[0]
        if len(self.moment) == 0:  # NumPy 1 has no rank for an empty matrix
            return max(moving, 1)
        return max(int(moving - np.linalg.matrix_rank(self.covariance, hermitian=True)), 1)

    @cached_property
    def amplitude(self) -> float:
        """Return the scale s² of G with the largest evidence, yᵀ P y / degrees."""
        return self.squares / self.degrees

    @property
    def deviations(self) -> Floats:
        """Return (B,) the standard deviations of the coefficients under white noise."""
        return np.sqrt(np.maximum(self.amplitude * np.diag(self.covariance), 0.0))

    @property
    def prior_amplitude(self) -> float:
        """Return the scale of the kernel and of the covariance for correlated samples."""
        return self.amplitude

    @property
    def log_evidence(self) -> float:
        """Return the restricted log evidence of the torques in nats, maximised over s²."""
        seen = np.linalg.eigvalsh(self.covariance)
        seen = seen[seen > seen.max(initial=0.0) * 1e-14]
        fit = self.degrees * (np.log(2.0 * np.pi * self.amplitude) + 1.0)
        log_det = self.log_det - self.at_rest[1]
        return -0.5 * (fit + log_det - float(np.sum(np.log(seen))))
