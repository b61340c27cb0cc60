"""What a solved semi-parametric model says of its basis and of itself, however it was solved.

With G the covariance of n torques y and Φ their basis, everything here follows from Φᵀ G⁻¹ Φ,
Φᵀ G⁻¹ y, yᵀ P y and log |G|; see `system` for P.
"""

from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Made = TypeVar("Made")

UNSEEN = 1e-11
"""Share of the largest eigenvalue of the scaled information below which nothing shows."""

DUST = 1e-75
"""A column of the basis below this, over its noise, is none: its square's inverse overflows."""


STRONGER = 10.0 ** np.arange(7)
"""What too little noise is multiplied with, one after the other, until there is a factor."""


class NotPositiveDefiniteError(ArithmeticError):
    """The regularised Gram matrix has no Cholesky factor: more regularisation is needed."""


def with_least_noise(attempt: Callable[[float], Made]) -> tuple[Made, float]:
    """What is made with the least noise that there is a factor with, and how often it is taken.

    Args:
        attempt: with the noise so many times as large as it was chosen.

    Raises:
        NotPositiveDefiniteError: there is none with much more noise either.
    """
    for factor in STRONGER:
        try:
            return attempt(float(factor)), float(factor)
        except NotPositiveDefiniteError as error:
            last = str(error)
    raise NotPositiveDefiniteError(f"no factor with {STRONGER[-1]:g} times the noise: {last}")


@dataclass(frozen=True)
class LeftOut:
    """A group of rows the fit did not see.

    Attributes:
        rows: (R,) which.
        residual: (R,) their torque minus the prediction of a fit to all other rows.
        change: (B,) how far the basis coefficients move when these rows are left out.
    """

    rows: Ints
    residual: Floats
    change: Floats


@dataclass(frozen=True)
class Pulled:
    """How a solution gives way where functionals of its torque are pulled at.

    Attributes:
        covariance: (R, R) of the functionals, over s²: what the data leave of their prior.
        moved: for pulls (R,), how far the weights (C n,) and the coefficients (B,) move; besides,
            the kernel of each functional joins the sum, multiplied by its pull.
    """

    covariance: Floats
    moved: Callable[[Floats], tuple[Floats, Floats]]


class Solution(ABC):
    """The torques of the joints that are solved together, solved."""

    @property
    @abstractmethod
    def count(self) -> int:
        """n, the number of torques."""

    @property
    @abstractmethod
    def information(self) -> Floats:
        """(B, B) Φᵀ G⁻¹ Φ."""

    @property
    @abstractmethod
    def moment(self) -> Floats:
        """(B,) Φᵀ G⁻¹ y."""

    @property
    @abstractmethod
    def squares(self) -> float:
        """The whitened squares left over, yᵀ P y."""

    @property
    @abstractmethod
    def log_det(self) -> float:
        """log |G|."""

    @property
    @abstractmethod
    def weights(self) -> Floats:
        """(C n,) what the kernel at the model's centres is multiplied by."""

    @abstractmethod
    def variance(self, cross: Floats, design: Floats) -> tuple[Floats, Floats]:
        """How much of a torque's variance the data explain, over s².

        Args:
            cross: (C n, R) kernel between the model's centres and R torques.
            design: (R, B) the basis there.

        Returns:
            (R,) what the prior variance of the kernel falls by, and (R,) what the uncertainty of
            the basis adds.
        """

    @abstractmethod
    def pulled(self, prior: Floats, cross: Floats, design: Floats) -> Pulled:
        """What some functionals of the torque, as a sum of several, may be moved to, and how.

        Args:
            prior: (R, R) their kernel.
            cross: (C n, R) kernel between the model's centres and them.
            design: (R, B) the basis there.
        """

    @cached_property
    def _half_covariance(self) -> Floats:
        """(B, seen) H with H Hᵀ the covariance: a direction nothing shows in gets no weight."""
        scale = np.sqrt(np.diag(self.information))
        scale[scale < DUST] = 1.0
        values, vectors = np.linalg.eigh(self.information / np.outer(scale, scale))
        seen = values > values.max(initial=0.0) * UNSEEN
        return np.asarray(vectors[:, seen] / np.sqrt(values[seen]) / scale[:, None])

    @cached_property
    def covariance(self) -> Floats:
        """(B, B) inverse of the information."""
        return np.asarray(self._half_covariance @ self._half_covariance.T)

    @cached_property
    def coefficients(self) -> Floats:
        """(B,) b, what the basis is multiplied by."""
        return np.asarray(self.covariance @ self.moment)

    @cached_property
    def degrees(self) -> int:
        """Torques minus the directions of the basis that they determine."""
        if len(self.moment) == 0:  # NumPy 1 has no rank for an empty matrix
            return self.count
        return int(self.count - np.linalg.matrix_rank(self.covariance, hermitian=True))

    @cached_property
    def amplitude(self) -> float:
        """The variance s² that multiplies G where the evidence is largest, yᵀ P y / degrees."""
        return self.squares / self.degrees

    @property
    def prior_amplitude(self) -> float:
        """The variance that multiplies the kernel and what is told by samples that err alike."""
        return self.amplitude

    @property
    def log_evidence(self) -> float:
        """Restricted log evidence of the torques, its amplitude s² at the best value, in nats."""
        seen = np.linalg.eigvalsh(self.covariance)
        seen = seen[seen > seen.max(initial=0.0) * 1e-14]
        return -0.5 * (
            self.degrees * (np.log(2.0 * np.pi * self.amplitude) + 1.0)
            + self.log_det
            - float(np.sum(np.log(seen)))
        )
