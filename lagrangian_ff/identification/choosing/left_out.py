"""The error on blocks of the training motion left out in turn, and whether one is surely less."""

from collections.abc import Sequence

import numpy as np
import scipy

from lagrangian_ff.arrays import Floats, Ints
from lagrangian_ff.errors import ModelError
from lagrangian_ff.identification.problem import STUCK_NOISE, Problem
from lagrangian_ff.identification.samples import Samples
from lagrangian_ff.identification.solving.posterior import Posterior, exact
from lagrangian_ff.identification.solving.solution import NotPositiveDefiniteError

SURE = 0.95
"""Confidence with which folds left out must find an error less than another."""
LEAST_ERROR = 1e-12
"""Of a joint's error relative to its variance: rounding is no difference."""


def require_folds(samples: Samples) -> None:
    """Refuse motion with a single block, of which no part can be left out.

    Raises:
        ModelError: there is only one block.
    """
    if len(samples.groups()) < 2:
        raise ModelError(
            "a model is judged on blocks of its training motion left out in turn, which needs at "
            "least two of them, got one: record longer, use a larger --train, or a shorter --block"
        )


def validation_score(found: Posterior, groups: Sequence[Ints]) -> Floats:
    """Return (N,) each joint's mean squared error on left-out folds, over its torque's variance.

    Each torque counts by its IRLS weight, that of a joint at rest hardly. NaN for a joint that was
    not solved.
    """
    residual = found.left_out(groups)
    samples = found.problem.samples
    weights = samples.weights / np.where(samples.x.rest, STUCK_NOISE, 1.0)
    errors = weights * (residual / found.problem.prior.scaling.spread) ** 2
    seen = np.isfinite(errors)
    counted = np.sum(weights, axis=0, where=seen)
    with np.errstate(invalid="ignore"):
        return np.asarray(np.sum(errors, axis=0, where=seen) / counted)


def fold_errors(problem: Problem) -> Floats:
    """Return (F, N) the joints' scores on each fold left out; inf without a Cholesky factor."""
    samples = problem.samples
    groups = samples.groups()
    try:
        found = exact(problem)
        return np.array([validation_score(found, [group]) for group in groups])
    except (NotPositiveDefiniteError, np.linalg.LinAlgError):
        return np.full((len(groups), samples.x.joints), np.inf)


def mean_logs(errors: Floats) -> Floats:
    """Return (F,) the mean log of the joints' errors (F, N), NaN left out.

    It is, up to a factor, minus the predictive log likelihood of torques whose joints have noise of
    unknown size each: a joint whose torque is mostly noise counts no more than one predicted to a
    thousandth. In the mean of the errors it would decide alone.
    """
    known = np.isfinite(errors)
    logs = np.log(np.maximum(np.where(known, errors, 1.0), LEAST_ERROR))
    with np.errstate(invalid="ignore"):
        mean = np.sum(logs, axis=1) / np.sum(known, axis=1)
    return np.where(np.any(known, axis=1), mean, np.inf)


def typical(folds: Floats) -> float:
    """Return the error of log errors by fold (F,)."""
    return float(np.exp(np.mean(folds)))


def surely_less(folds: Floats, others: Floats) -> bool:
    """Return whether log errors by fold (F,) are less than others by more than chance.

    A one-sided paired t-test at the 5 % level tells; of fewer than two folds nothing is sure.
    """
    if len(folds) < 2 or not np.all(np.isfinite(folds)):
        return False
    if not np.all(np.isfinite(others)):
        return True
    gain = others - folds
    error = np.std(gain, ddof=1) / np.sqrt(len(gain))
    return bool(np.mean(gain) > scipy.special.stdtrit(len(gain) - 1, SURE) * error)
