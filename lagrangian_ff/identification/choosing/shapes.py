"""The shape of an effect that explains most of what a fitted model leaves over."""

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solve_triangular

from lagrangian_ff.effects import Effect, Inputs
from lagrangian_ff.identification.basis import Term
from lagrangian_ff.identification.solving.fit import Fit

Floats = NDArray[np.float64]


def best_shape(fitted: Fit, effect: Effect, joint: int, x: Inputs) -> Mapping[str, float]:
    """The shape with the largest fall of the whitened squared residual; no refit is needed.

    Args:
        fitted: the model so far.
        effect, joint: what is to be added where.
        x: (C,) the samples it was fitted on.
    """
    shapes = effect.candidates(x, joint)
    return max(shapes, key=lambda shape: fall(fitted, Term(effect, joint, shape), x)[0])


def fall(fitted: Fit, term: Term, x: Inputs) -> tuple[float, float]:
    """How much a term would explain of the whitened squares.

    Returns:
        The fall as a share of what is left, and the share of the term itself that the model's
        basis does not hold already: 0 for a torque it has under another name.
    """
    for joints, _, system in fitted.systems:
        if term.joint not in joints:
            continue
        columns = term.columns(x)
        place = joints.index(term.joint)
        full = np.zeros((len(x), len(joints), columns.shape[1]))
        full[:, place, :] = columns / np.maximum(np.abs(columns).max(axis=0), 1e-300)
        z = solve_triangular(
            system.upper, full.reshape(-1, columns.shape[1]), trans=1, check_finite=False
        )
        size = float(np.sum(z**2))
        span = _orthonormal(system.white_design)
        z -= span @ (span.T @ z)
        left = system.white_target - span @ (span.T @ system.white_target)
        own = float(np.sum(z**2)) / size if size > 0.0 else 0.0
        if own < 1e-12:
            return 0.0, own
        direction = _orthonormal(z)
        return float(np.sum((direction.T @ left) ** 2) / (left @ left)), own
    raise ValueError(f"joint {term.joint} is in no system of the fit")


def _orthonormal(columns: Floats) -> Floats:
    if columns.shape[1] == 0:
        return columns
    scale = np.sqrt(np.sum(columns**2, axis=0))
    left, values, _ = np.linalg.svd(
        columns / np.where(scale > 0.0, scale, 1.0), full_matrices=False
    )
    return np.asarray(left[:, values > 1e-9 * values.max(initial=0.0)])
