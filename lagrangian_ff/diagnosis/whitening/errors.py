"""Columns of what may be a little wrong in a model: the shapes of its effects, the torque's lag.

They are explained with the effects, so that nothing is found that only makes up for them.
"""

import numpy as np
from scipy.linalg import solve_triangular

from lagrangian_ff.arrays import Floats
from lagrangian_ff.effects import Inputs
from lagrangian_ff.identification.basis import Basis
from lagrangian_ff.identification.problem import Nuisance, Problem

TANGENT = 0.03
"""Relative step of the derivative with respect to a shape."""


def errors_of_shapes(basis: Basis, x: Inputs) -> list[Nuisance]:
    """Return the derivatives of the columns by the shapes: to first order, the shapes' errors."""
    return [
        Nuisance(up.joint, (up.columns(x) - down.columns(x)) / TANGENT)
        for up, down in basis.tangents(TANGENT)
    ]


def error_of_lag(problem: Problem, upper: Floats) -> Floats:
    """Return -dτ/dt of all joints, whitened, (S N,): to first order, a lag of one second.

    Args:
        problem: of the samples used, whose torque is predicted.
        upper: (S N, S N) the Cholesky factor U of its Gram matrix.
    """
    x = problem.samples.x
    whole = x.whole or x
    rate = x.mean(-whole.rate(whole.torque)) / problem.unit
    return np.asarray(solve_triangular(upper, rate.ravel(), trans=1, check_finite=False))
