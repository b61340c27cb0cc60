"""Fits that gross errors of torque cannot drag: Huber's loss in place of the square.

Problem (44) with any convex loss has a solution of the form (45), by the representer theorem. With
Huber's loss (Annals of Mathematical Statistics 35, 1964) a residual beyond δ counts by its size and
no longer by its square, so that no torque pulls harder than one with residual δ, however wrong it
is. Iteratively reweighted least squares solves it: the noise of a torque with residual r is divided
by its trust min(1, δ / |r|), until nothing changes. δ is a multiple of each joint's own noise,
taken from the median of its residuals, which outliers hardly move.
"""

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from lagrangian_ff.identification.choice import Scaling
from lagrangian_ff.identification.solving.fit import Fit
from lagrangian_ff.progress import Progress, part, silent

Floats = NDArray[np.float64]

THRESHOLD = 1.345
"""δ in standard deviations: 95 % as efficient as least squares where noise is normal."""
DEVIATION = 1.4826
"""The standard deviation of normal numbers over the median of their magnitudes."""
LEAST = 1e-6
"""Of the torque's spread, the least δ: below it are errors of rounding."""
HALF = 0.5
"""Torques that are trusted less are told as outliers: of normal noise, 7 of 1000."""
SETTLED = 10
"""Steps after which δ stays."""
STEPS = 80
FEW_STEPS = 6
"""Where each is a look at all samples, and the first trust is a good guess."""
ENOUGH, ROUGH = 1e-3, 1e-2
"""Of the pull of a residual δ: torques that pull this much too hard are not worth a step."""


class Solvable(Protocol):
    """All of a problem but the trust in each torque: `Equations`, or `LandmarkEquations`."""

    @property
    def scaling(self) -> Scaling:
        """Of the torques."""

    def solve(
        self, trust: Floats | None = None, *, last: bool = True, progress: Progress = silent
    ) -> Fit:
        """Solve for the trust (M, N) in each torque; None trusts all."""


@dataclass(frozen=True)
class Robust:
    """A fit with Huber's loss.

    Attributes:
        fitted: with the trust of the last step; it minimises the loss of this threshold.
        threshold: (N,) N·m, δ.
    """

    fitted: Fit
    threshold: Floats


def huber(
    equations: Solvable,
    trust: Floats | None = None,
    threshold: Floats | None = None,
    enough: float = ENOUGH,
    steps: int = STEPS,
    progress: Progress = silent,
) -> Robust:
    """Solve (44) with Huber's loss.

    Args:
        equations: all but the trust.
        trust: (M, N) to begin with; None trusts all.
        threshold: (N,) N·m, δ; None takes it from the residuals.
        enough: when to stop, see `ENOUGH`.
        steps: after how many to stop in any case.
        progress: told the share done, at most.

    Raises:
        NotPositiveDefiniteError: the noise is too small for the arithmetic.
    """
    limit = threshold
    fitted = equations.solve(trust, last=False, progress=part(progress, 0.0, 1.0 / (steps + 1)))
    for step in range(steps):
        share = part(progress, (step + 1) / (steps + 1), (step + 2) / (steps + 1))
        share(0.0, "weighing torques")
        residual = fitted.residual
        if threshold is None and (limit is None or step < SETTLED):
            limit = threshold_of(residual, equations.scaling.spread)
        assert limit is not None
        wanted = trust_in(residual, limit)
        if np.max(np.abs((wanted - fitted.trust) * residual) / limit) < enough:
            break
        fitted = equations.solve(wanted, last=False, progress=share)
    assert limit is not None
    return Robust(fitted, limit)


def threshold_of(residual: Floats, spread: Floats) -> Floats:
    """(N,) N·m, δ of each joint, for residuals (M, N) and the spread (N,) of the torque."""
    deviation = DEVIATION * np.median(np.abs(residual), axis=0)
    return np.asarray(np.maximum(THRESHOLD * deviation, LEAST * spread))


def trust_in(residual: Floats, threshold: Floats) -> Floats:
    """(M, N) the weights of Huber's loss for residuals (M, N) and δ (N,)."""
    return np.asarray(threshold / np.maximum(np.abs(residual), threshold))


def doubted(trust: Floats) -> Floats:
    """(M, N) the trust under which an outlier of any size says as much as a residual δ.

    Huber's own lets what an outlier adds to the sum of squares grow with its size. That sum is what
    the evidence, the noise and intervals are made of; there an outlier has a noise of its own
    size, as under a distribution with heavy tails.
    """
    return np.square(trust)


def at_sight(tau: Floats) -> Floats:
    """(M, N) trust in torques (M, N) before anything is fitted, by their distance from the median.

    Enough to tell the spread of a joint's torque.
    """
    away = tau - np.median(tau, axis=0)
    spread = np.std(tau, axis=0)
    return trust_in(away, threshold_of(away, np.where(spread > 0.0, spread, 1.0)))
