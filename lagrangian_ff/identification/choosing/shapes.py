"""The shapes of effects that explain most of a posterior's residual."""

from collections.abc import Collection, Mapping
from dataclasses import replace

import numpy as np
import scipy
from scipy.linalg import solve_triangular

from lagrangian_ff.arrays import Floats
from lagrangian_ff.effects import Effect
from lagrangian_ff.errors import ModelError
from lagrangian_ff.identification.basis import Basis, Term
from lagrangian_ff.identification.solving.posterior import Posterior
from lagrangian_ff.identification.solving.system import System
from lagrangian_ff.kernels.threads import one_blas_thread

STEP = 0.4
"""First step of the logarithm of a shape."""
EVALUATIONS = 40
"""Evaluations for each shape, at most."""


def best_shape(
    found: Posterior[System], effect: Effect, joint: int, given: Mapping[str, float]
) -> Mapping[str, float]:
    """Return the shape with the largest fall of the whitened squared residual; no refit is needed.

    Args:
        found: posterior of the model so far.
        effect, joint: to add.  given: known values of the shape.

    Raises:
        ModelError: the motion leaves no shape to try.
    """
    x = found.problem.samples.x
    if given and all(shape.name in given for shape in effect.shapes):
        return dict(given)
    tried = [{**shape, **given} for shape in effect.candidates(x, joint)]
    shapes = {tuple(shape.items()): shape for shape in tried}.values()
    if not shapes:
        raise ModelError(
            f"{effect.name}: the motion that the model keeps leaves no shape of it to try on this "
            "joint, being too short, too still, of too few joints, or without what it depends on; "
            f"the motion that shows it: {effect.next_motion}"
        )
    return max(shapes, key=lambda shape: fall(found, Term(effect, joint, shape))[0])


def fall(found: Posterior[System], term: Term) -> tuple[float, float]:
    """Return the share of the whitened squares that a term would explain.

    Returns:
        The fall as a share of the squares, and the share of the term itself that the model's
        basis does not hold already: 0 for a torque that it has under another name.
    """
    joints, _, system = system_of(found, term.joint)
    columns = term.columns(found.problem.samples.x)
    z = _whitened(system, term.on(found.states.joints)[list(joints)], columns)
    size = float(np.sum(z**2))
    span = orthonormal(system.white_design)
    z -= span @ (span.T @ z)
    left = system.white_target - span @ (span.T @ system.white_target)
    own = float(np.sum(z**2)) / size if size > 0.0 else 0.0
    if own < 1e-12:
        return 0.0, own
    direction = orthonormal(z)
    return float(np.sum((direction.T @ left) ** 2) / (left @ left)), own


def refit_shapes(
    found: Posterior[System], basis: Basis, joint: int, given: Collection[tuple[str, str]] = ()
) -> Basis:
    """Return the basis with the shapes of one joint's friction where the residual is least.

    A shape that was chosen while an effect was missing had made up for it as well as it could:
    Coulomb's v0 for a bump at creeping speed.

    Args:
        found: posterior of the model so far, which gives the kernel and the noise.
        basis: its terms, moved or new.  joint: to refit the friction of.
        given: effect and name of each shape that stays.
    """
    x = found.problem.samples.x
    joints, part, system = system_of(found, joint)
    free = [
        (number, shape)
        for number, term in enumerate(basis.terms)
        if term.joint == joint and term.effect.kind == "friction"
        for shape in term.effect.shapes
        if (term.effect.name, shape.name) not in given
        and not shape.whole
        and term.shape.get(shape.name, 0.0) > shape.zero
    ]
    if not free:
        return basis
    rows = np.arange(joints.index(joint), system.count, len(joints))
    known = orthonormal(system.white_design[:, part.joints != joint])
    try:
        upper, target, squares = system.seen_by(rows, known)
    except np.linalg.LinAlgError:  # a change of shape would drown in rounding, too
        return basis

    def moved(logs: Floats) -> Basis:
        terms = list(basis.terms)
        for (number, shape), log in zip(free, logs.tolist(), strict=True):
            shapes = {**terms[number].shape, shape.name: shape.value(log)}
            terms[number] = replace(terms[number], shape=shapes)
        return Basis(tuple(terms))

    def cost(logs: Floats) -> float:
        own = moved(logs)
        seen = replace(x, sign_speed=own.sign_speed(x.joints))
        columns = own.of_joints((joint,)).columns(seen)
        direction = orthonormal(upper @ columns)
        return float(np.log(squares - np.sum((direction.T @ target) ** 2)))

    ends = [(one.logarithm(one.low), one.logarithm(one.high)) for _, one in free]
    low, high = np.array(ends).T
    present = np.array([one.logarithm(basis.terms[n].shape[one.name]) for n, one in free])
    start = np.clip(present, low, high)  # models of other versions may have it outside
    step = np.where(
        start + STEP > high, -STEP, STEP
    )  # outside, SciPy 1.11 moves it back onto start
    simplex = start + np.vstack([np.zeros(len(free)), np.diag(step)])
    bounds = list(zip(low, high, strict=True))
    # Threads cost more than they bring on matrices as small as these.
    with one_blas_thread():
        optimum = scipy.optimize.minimize(
            cost, start, method="Nelder-Mead", bounds=bounds,
            options={"initial_simplex": simplex, "maxfev": EVALUATIONS * len(free),
                     "xatol": 0.01, "fatol": 1e-5},
        )  # fmt: skip
    return moved(optimum.x) if optimum.fun < cost(present) else basis


def system_of(found: Posterior[System], joint: int) -> tuple[tuple[int, ...], Basis, System]:
    """Return the joints that are solved with one, their part of the basis, and their system."""
    for joints, part, system in found.systems:
        if joint in joints:
            return joints, part, system
    raise ValueError(f"joint {joint} is in no system of the posterior")


def _whitened(system: System, on: Floats, columns: Floats) -> Floats:
    """Return (n, P) columns (M, P), of largest entry 1, whitened with G.

    Args:
        on: (n,) their factor in the torque of each joint of the system.
    """
    scale = np.maximum(np.abs(columns).max(axis=0), 1e-300)
    full = (columns / scale)[:, None, :] * on[:, None]
    flat = full.reshape(-1, columns.shape[1])
    return np.asarray(solve_triangular(system.upper, flat, trans=1, check_finite=False))


def orthonormal(columns: Floats) -> Floats:
    """Return (n, R) orthonormal columns that span those of (n, P)."""
    if columns.shape[1] == 0:
        return columns
    scale = np.sqrt(np.sum(columns**2, axis=0))
    scaled = columns / np.where(scale > 0.0, scale, 1.0)
    left, values, _ = np.linalg.svd(scaled, full_matrices=False)
    return np.asarray(left[:, values > 1e-9 * values.max(initial=0.0)])
