"""The nearest solution whose mass matrix is positive definite along the motion.

For a direction v, vᵀ M(q) v is a bounded linear functional of the Lagrangian: what acceleration v
adds to the torque, times v. That it shall be at least ε at some states is a convex constraint, and
the fit that obeys it is, by the representer theorem, the free one with centres at these states
added, weighed by multipliers µ ≥ 0. With m the values of the free fit at the constraints and S
their posterior covariance, both from the factor at hand,

    µ = argmin ½ µᵀ S µ − µᵀ (ε − m),  µ ≥ 0,

a non-negative least squares problem. Cutting planes (Kelley 1960, J. SIAM 8(4)): where the least
eigenvalue is too small, its direction is the next constraint, until there is none.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
import scipy
from scipy.linalg import solve_triangular

from lagrangian_ff.arrays import Floats, Ints
from lagrangian_ff.effects import Inputs
from lagrangian_ff.errors import ModelError
from lagrangian_ff.identification.mechanics.dynamics import least, mass_of
from lagrangian_ff.identification.samples import evenly
from lagrangian_ff.identification.solving.posterior import Posterior
from lagrangian_ff.identification.solving.solution import Solution
from lagrangian_ff.kernels import CoupledKernel, States
from lagrangian_ff.progress import Progress, silent

FLOOR = 0.02
"""Least eigenvalue of the mass matrix, in parts of the joints' own inertia."""
ENOUGH = 0.5
"""Least eigenvalue between the constrained states, in parts of the floor."""
ROUNDS = 40
A_ROUND = 20
"""Constraints added at once."""
WATCHED = 150
"""States checked in every round; the others once these satisfy the floor."""
JITTER = 1e-9


@dataclass(frozen=True)
class Expansion:
    """Centres and coefficients of a torque, as a `Posterior` has them.

    Attributes:
        states: (C, N) centres of the posterior, then those of constraints.
        weights: (C, N) of all centres.  coefficients: (B,).
    """

    states: States
    weights: Floats
    coefficients: Floats


@dataclass(frozen=True)
class _Cuts:
    """Constraints vᵀ M(q, qd) v ≥ ε: (R, N) q, qd and v."""

    q: Floats
    qd: Floats
    v: Floats

    def sides(self) -> Iterator[tuple[float, States]]:
        """Yield the states whose torques' difference is M v, each with its sign."""
        yield 1.0, States(self.q, self.qd, self.v)
        yield -1.0, States(self.q, self.qd, np.zeros_like(self.v))

    def with_more(self, other: "_Cuts") -> "_Cuts":
        parts = ((getattr(one, name) for one in (self, other)) for name in ("q", "qd", "v"))
        return _Cuts(*(np.vstack(list(part)) for part in parts))


def keep_positive(
    posterior: Posterior, at: States, progress: Progress = silent
) -> Posterior | Expansion:
    """Solve again so that the mass matrix is positive definite at some states.

    Args:
        posterior: without constraints, of a coupled kernel and one unit of torque.
        at: (M, N) the states; their acceleration is ignored.
        progress: receives the share done, 0 to 1.

    Raises:
        ModelError: no such solution of this kernel was found.
    """
    system = posterior.system
    none = np.empty((0, at.joints))
    cuts = _Cuts(none, none, none)
    solution: Posterior | Expansion = posterior
    watched = evenly(len(at), WATCHED)
    mass = _mass(posterior, solution, at.take(watched))
    scale = np.sqrt(np.median(np.abs(np.einsum("inn->in", mass)), axis=0))

    def short(among: Ints) -> tuple[Ints, Floats]:
        """Return those of some states that violate the floor, and in which direction."""
        found = _mass(posterior, solution, at.take(among)) / np.outer(scale, scale)
        values, directions = least(found)
        bad = np.flatnonzero(values < FLOOR * ENOUGH)
        some = bad[evenly(len(bad), A_ROUND)]
        if len(bad):
            some = np.union1d(some, bad[np.argmin(values[bad])])
        return among[some], directions[some]

    for number in range(ROUNDS):
        progress(number / ROUNDS, "keeping the mass matrix positive")
        bad, directions = short(watched)
        if not len(bad):
            bad, directions = short(np.arange(len(at)))
            watched = np.union1d(watched, bad)
        if not len(bad):
            return solution
        cuts = cuts.with_more(_Cuts(at.q[bad], at.qd[bad], directions / scale))
        solution = _solve(posterior, system, cuts)
    raise ModelError(
        f"no fit of {posterior.problem.kernel.name} was found whose mass matrix is positive "
        f"definite along the motion, within {ROUNDS} rounds; identify without --positive, with "
        "another kernel, or with more motion"
    )


def _solve(posterior: Posterior, system: Solution, cuts: _Cuts) -> Expansion:
    """Return the solution under some constraints."""
    kernel = posterior.problem.kernel
    assert isinstance(kernel, CoupledKernel)
    count = len(cuts.v)
    cross = np.zeros((system.weights.size, count))
    prior = np.zeros((count, count))
    design = np.zeros((count, posterior.problem.basis.size))
    for sign, state in cuts.sides():
        cross += sign * _along(kernel.cross(posterior.states, state), cuts.v)
        design += sign * np.einsum("rn,rnb->rb", cuts.v, _kept_design(posterior, state))
        for other_sign, other in cuts.sides():
            block = _along(kernel.cross(other, state), cuts.v).reshape(count, -1, count)
            prior += sign * other_sign * np.einsum("rn,rns->rs", cuts.v, block)
    pulled = system.pulled(prior, cross, design)
    value = cross.T @ system.weights + design @ system.coefficients
    multipliers = _multipliers(pulled.covariance, FLOOR - value)
    weights, coefficients = pulled.moved(multipliers)
    weights += system.weights
    coefficients += system.coefficients
    active = np.flatnonzero(multipliers)
    added = multipliers[active, None] * cuts.v[active]
    sides = [(sign, state.take(active)) for sign, state in cuts.sides()]
    centres = [posterior.states, *(state for _, state in sides)]
    return Expansion(
        States(*(np.vstack([getattr(c, name) for c in centres]) for name in ("q", "qd", "qdd"))),
        np.vstack([weights.reshape(-1, cuts.v.shape[1]), *(sign * added for sign, _ in sides)]),
        coefficients,
    )


def _multipliers(covariance: Floats, missing: Floats) -> Floats:
    """Return µ ≥ 0, (R,), of least ½ µᵀ S µ − µᵀ missing."""
    jitter = JITTER * float(np.trace(covariance)) / len(covariance)
    lower = np.linalg.cholesky(covariance + jitter * np.eye(len(covariance)))
    target = solve_triangular(lower, missing, lower=True, check_finite=False)
    return np.asarray(scipy.optimize.nnls(lower.T, target, maxiter=100 * len(missing))[0])


def _along(block: Floats, v: Floats) -> Floats:
    """Return (X, R) a kernel (X, R N) with the torques at R states projected on v (R, N)."""
    return np.asarray(np.einsum("xrn,rn->xr", block.reshape(-1, *v.shape), v))


def _kept_design(posterior: Posterior, x: States) -> Floats:
    """Return (R, N, B) the basis of the effects that keep energy, zero for the others, per unit."""
    kept = {id(term) for term in posterior.problem.basis.conservative(x.joints).terms}
    inputs, out = Inputs.of(x), np.zeros((*x.q.shape, posterior.problem.basis.size))
    for term, place in posterior.problem.basis.slices():
        if id(term) in kept:
            out[:, term.joint, place] = term.columns(inputs)
    return out / posterior.problem.unit[None, :, None]


def _mass(posterior: Posterior, solution: Posterior | Expansion, at: States) -> Floats:
    """Return the mass matrices (M, N, N), in units of torque."""

    def torque(x: States) -> Floats:
        kernel = posterior.problem.kernel.apply(x, solution.states, solution.weights)
        return np.asarray(kernel + _kept_design(posterior, x) @ solution.coefficients)

    return mass_of(torque, replace(at, qdd=np.zeros_like(at.q)))
