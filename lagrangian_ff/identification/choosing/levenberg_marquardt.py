"""Maximising a log density over logarithms of hyperparameters by damped steps."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Generic, TypeVar

import numpy as np
from scipy.linalg import cho_factor, cho_solve

from lagrangian_ff.arrays import Floats
from lagrangian_ff.identification.solving.solution import NotPositiveDefiniteError

Found = TypeVar("Found")

PRIOR_DEVIATION = 3.0
"""Standard deviation of the logarithm of a hyperparameter about its start."""
RARITY = 2.0
"""Nats that each multiple of the initial standard deviation of a torque costs."""
LONGEST = 1.5
"""The longest step of a logarithm."""
ENOUGH = 0.05
"""Nats that a step must bring for another to be tried, by default."""
TRIALS = 8


@dataclass(frozen=True)
class Derivatives:
    """Derivatives of a log density by K logarithms.

    Attributes:
        gradient: (K,).  curvature: (K, K) minus the second derivative, about.
    """

    gradient: Floats
    curvature: Floats


@dataclass(frozen=True)
class HyperPrior:
    """A weak prior of logarithms: each is normal about its start.

    Of some variances the square root has an exponential prior besides (Simpson et al., Statistical
    Science 32, 2017): a torque many times as large as any measured one is improbable, though the
    samples of a joint that hardly moves may favour it.

    Attributes:
        middle: (K,) the start.
        variances: (K,) 1 for logarithms of such variances, else 0; None has none.
    """

    middle: Floats
    variances: Floats | None = None

    def log_density(self, point: Floats) -> float:
        """Return the log density of a point (K,), but for a constant."""
        away = (point - self.middle) / PRIOR_DEVIATION
        return -0.5 * float(away @ away) - float(np.sum(self._size(point)))

    def derivatives(self, point: Floats) -> Derivatives:
        """Return the derivatives of the log density at a point (K,)."""
        size = self._size(point)
        gradient = (self.middle - point) / PRIOR_DEVIATION**2 - 0.5 * size
        return Derivatives(gradient, np.diag(1.0 / PRIOR_DEVIATION**2 + 0.25 * size))

    def _size(self, point: Floats) -> Floats:
        if self.variances is None:
            return np.zeros_like(point)
        return RARITY * self.variances * np.exp(0.5 * (point - self.middle))


@dataclass(frozen=True)
class Density(Generic[Found]):
    """A log density over logarithms (K,): that of a prior plus the log evidence.

    Attributes:
        prior: of the logarithms, before any torque is seen.
        at: solves the problem at a point; raises NotPositiveDefiniteError where the Gram matrix is
            not positive definite.
        log_evidence, derivatives: of the solution at a point.
        inside: returns the nearest point of the range.
    """

    prior: HyperPrior
    at: Callable[[Floats], Found]
    log_evidence: Callable[[Found], float]
    derivatives: Callable[[Found], Derivatives]
    inside: Callable[[Floats], Floats] = np.asarray

    def maximised(
        self,
        point: Floats,
        steps: int,
        report: Callable[[int], None] = lambda _: None,
        enough: float = ENOUGH,
        damping: float = 1.0,
    ) -> tuple[Floats, Found]:
        """Return a maximum and the solution there (Levenberg 1944, Marquardt 1963).

        Args:
            point: where to begin.  steps: at most.
            report: receives the number of each step.
            enough: nats that a step must bring for another to be tried.
            damping: of the first step; the farther the maximum may be, the more.

        Raises:
            NotPositiveDefiniteError: the Gram matrix is not positive definite at the first point.
        """
        point = self.inside(point)
        found = self.at(point)
        best = self.log_evidence(found) + self.prior.log_density(point)
        for step in range(steps):
            report(step)
            before = best
            own, prior = self.derivatives(found), self.prior.derivatives(point)
            gradient = own.gradient + prior.gradient
            curvature = own.curvature + prior.curvature
            for _ in range(TRIALS):
                try:
                    move = _step(gradient, curvature, damping)
                    moved = self.inside(point + move)
                    tried = self.at(moved)
                    density = self.log_evidence(tried) + self.prior.log_density(moved)
                except (NotPositiveDefiniteError, np.linalg.LinAlgError):
                    density = -np.inf
                if density > best:
                    point, found, best = moved, tried, density
                    damping *= 0.2
                    break
                damping *= 8.0
            if best - before < enough:
                break
        return point, found


def _step(gradient: Floats, curvature: Floats, damping: float) -> Floats:
    """Return the damped Newton step, no logarithm moved by more than `LONGEST`.

    Raises:
        LinAlgError: the damped curvature is not positive definite, or not finite: the data say
            nothing of a number.
    """
    if not (np.isfinite(curvature).all() and np.isfinite(gradient).all()):
        raise np.linalg.LinAlgError("the curvature is not finite")
    scale = damping * np.diag(np.diag(curvature))
    step = cho_solve(cho_factor(curvature + scale), gradient)
    return np.asarray(np.clip(step, -LONGEST, LONGEST))
