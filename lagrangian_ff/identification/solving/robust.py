"""Huber's loss in place of the square, against gross errors of torque.

Problem (44) with any convex loss has a solution of the form (45), by the representer theorem. With
Huber's loss (Annals of Mathematical Statistics 35, 1964) a residual beyond δ counts by its size and
no longer by its square, so that no torque pulls harder than one with residual δ. Iteratively
reweighted least squares (IRLS) solves it: the noise of a torque with residual r is divided by its
weight min(1, δ / |r|), until nothing changes. δ is a multiple of each joint's own noise, taken from
the median of its residuals, which outliers hardly move.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lagrangian_ff.arrays import Floats
from lagrangian_ff.identification.solving.posterior import Posterior, Solver
from lagrangian_ff.progress import Progress, part, silent

THRESHOLD = 1.345
"""δ in standard deviations: 95 % as efficient as least squares where noise is normal."""
DEVIATION = 1.4826
"""The standard deviation of normal numbers over the median of their magnitudes."""
LEAST = 1e-6
"""Least δ in parts of the torque's spread; smaller residuals are rounding."""
HALF = 0.5
"""Torques that weigh less are reported as outliers: of normal noise, 7 of 1000."""
SETTLED = 10
"""Steps after which δ stays."""
STEPS = 80
FEW_STEPS = 6
"""The same on inducing points, where a step takes all samples and the first weights are good."""
ENOUGH, ROUGH = 1e-3, 1e-2
"""Error of a torque's pull, in parts of that of a residual δ, at which the steps end."""


@dataclass(frozen=True)
class Robust:
    """A fit with Huber's loss.

    Attributes:
        posterior: with the weights of the last step; it minimises the loss of this threshold.
        threshold: (N,) N·m, δ.
    """

    posterior: Posterior
    threshold: Floats


def huber(
    solve: Solver,
    weight: Floats | None = None,
    threshold: Floats | None = None,
    enough: float = ENOUGH,
    steps: int = STEPS,
    progress: Progress = silent,
) -> Robust:
    """Solve (44) with Huber's loss.

    Args:
        solve: the problem, for given IRLS weights.
        weight: (S, N) initial; None is 1 for all.
        threshold: (N,) N·m, δ; None takes it from the residuals.
        enough: error at which to stop, see `ENOUGH`.  steps: at most.
        progress: receives the share done, 0 to 1.

    Raises:
        NotPositiveDefiniteError: the noise is too small.
    """
    limit = threshold
    found = solve(weight, part(progress, 0.0, 1.0 / (steps + 1)))
    for step in range(steps):
        share = part(progress, (step + 1) / (steps + 1), (step + 2) / (steps + 1))
        share(0.0, "weighing torques")
        residual = found.residual
        if threshold is None and (limit is None or step < SETTLED):
            limit = threshold_of(residual, found.problem.prior.scaling.spread)
        assert limit is not None
        wanted = weights_of(residual, limit)
        if np.max(np.abs((wanted - found.problem.samples.weights) * residual) / limit) < enough:
            break
        found = solve(wanted, share)
    assert limit is not None
    return Robust(found, limit)


def threshold_of(residual: Floats, spread: Floats) -> Floats:
    """Return δ of each joint, (N,) N·m, for residuals (M, N) and spreads (N,) of the torque."""
    deviation = DEVIATION * np.median(np.abs(residual), axis=0)
    return np.asarray(np.maximum(THRESHOLD * deviation, LEAST * spread))


def weights_of(residual: Floats, threshold: Floats) -> Floats:
    """Return (M, N) the IRLS weights of Huber's loss for residuals (M, N) and δ (N,)."""
    return np.asarray(threshold / np.maximum(np.abs(residual), threshold))


def outliers_of(weight: Floats) -> NDArray[np.bool_]:
    """Return (M, N) which torques count less than half, for their IRLS weights (M, N)."""
    return np.asarray(weight < HALF)


def heavy_tailed(weight: Floats) -> Floats:
    """Return (S, N) the weights under which an outlier of any size counts as much as a residual δ.

    With Huber's own weights the part of an outlier in the sum of squares grows with its size.
    Evidence, noise and intervals follow from that sum; for them the noise of an outlier is as
    large as its residual, as under a distribution with heavy tails.
    """
    return np.square(weight)


def at_sight(tau: Floats) -> Floats:
    """Return initial weights (S, N) of torques (S, N) by their distance from the median.

    They serve for the spread of a joint's torque.
    """
    away = tau - np.median(tau, axis=0)
    spread = np.std(tau, axis=0)
    return weights_of(away, threshold_of(away, np.where(spread > 0.0, spread, 1.0)))
