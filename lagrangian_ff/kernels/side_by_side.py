"""Applying the universal Lagrangian kernels to coefficients: many centres side by side, no block.

With the names of `fused`, and for the coefficients a of a centre

    E = e·a,   P = p·a,   U = ū·a,   X = x̄·a,   R = Σ_j r_j qd_j a_j,

    K a / k = (c_x B − c_xu E − Y) e + B (p − x̄) − (c_x E − X) ū
              − E r∘qd' + r∘a + (c_xu − c_x c_u) w∘a,     B = c_u E − U − P,   Y = c_u X − R.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from lagrangian_ff.kernels.base import Learned
from lagrangian_ff.kernels.compiled import prepared
from lagrangian_ff.kernels.states import States

Floats = NDArray[np.float64]

LANES = 32
_OPTIONS: dict[str, Any] = {
    "cache": True,
    "nogil": True,
    "error_model": "numpy",
    "fastmath": {"contract", "nsz", "reassoc"},
}
_INNER = _OPTIONS | {"no_cpython_wrapper": True, "no_cfunc_wrapper": True}


@dataclass(frozen=True)
class SideBySide(Learned):
    """Torques learned at centres that lie joint by joint, so that loops over them are fast.

    Attributes:
        centres: q, qd, qdd, sin q, cos q and a, (6, N, C), C a multiple of `LANES`.
        weights: which coordinates are angles, α and w of `fused`.
    """

    centres: Floats
    weights: tuple[Any, Floats, Floats]

    @classmethod
    def of(cls, u: States, a: Floats, weights: tuple[Any, Floats, Floats]) -> "SideBySide":
        """What was learned at u (C, N) with coefficients a (C, N)."""
        count = -(-len(u) // LANES) * LANES
        centres = np.zeros((6, u.joints, count))
        for row, values in enumerate((*prepared(u), a)):
            centres[row, :, : len(u)] = values.T
        return cls(centres, weights)

    def torque(self, x: States) -> Floats:
        """See `Learned.torque`."""
        out = np.empty(x.q.shape)
        _apply(prepared(x), self.centres, *self.weights, out)
        return out


@njit(**_OPTIONS)
def _apply(x, u, angle, alpha, w, out):  # type: ignore[no-untyped-def]
    """Write Σ_j K(x_i, u_j) a_j to out[i]."""
    of_joint, total = np.empty((3, w.shape[0], LANES)), np.empty((8, LANES))
    for i in range(x[0].shape[0]):
        out[i, :] = 0.0
        for first in range(0, u.shape[2], LANES):
            _gather(i, first, x, u, angle, alpha, w, of_joint, total)
            _spread(i, first, x, u, w, of_joint, total, out)


@njit(**_INNER)
def _gather(i, first, x, u, angle, alpha, w, of_joint, total):  # type: ignore[no-untyped-def]
    """Fill e, p, r of every joint, and the sums over joints."""
    e, p, r = of_joint[0], of_joint[1], of_joint[2]
    exponent, cx, cu, cxu = total[0], total[1], total[2], total[3]
    ea, sa, xa, ra = total[4], total[5], total[6], total[7]
    total[:, :] = 0.0
    last = first + LANES
    for n in range(w.shape[0]):
        # Numbers apart from the arrays: a store to one array could change another, for all LLVM
        # knows, and then nothing runs side by side.
        weight, scale = w[n], alpha[n]
        place, v, acceleration = x[0][i, n], x[1][i, n], x[2][i, n]
        b = weight * acceleration
        q, vu, au = u[0, n, first:last], u[1, n, first:last], u[2, n, first:last]
        a = u[5, n, first:last]
        en, pn, rn = e[n], p[n], r[n]
        if angle[n]:
            sine, cosine = scale * x[3][i, n], scale * x[4][i, n]
            su, cos = u[3, n, first:last], u[4, n, first:last]
            for z in range(LANES):
                pn[z] = sine * cos[z] - cosine * su[z]
            for z in range(LANES):
                rn[z] = cosine * cos[z] + sine * su[z]
            for z in range(LANES):
                exponent[z] += rn[z] - scale
        else:
            for z in range(LANES):
                pn[z] = scale * (place - q[z])
            for z in range(LANES):
                exponent[z] -= 0.5 * pn[z] * (place - q[z])
            rn[:] = scale
        for z in range(LANES):
            en[z] = weight * (v - vu[z])
        for z in range(LANES):
            exponent[z] -= 0.5 * en[z] * (v - vu[z])
        for z in range(LANES):
            cx[z] += pn[z] * v + en[z] * acceleration
        for z in range(LANES):
            cu[z] += pn[z] * vu[z] + en[z] * au[z]
        for z in range(LANES):
            cxu[z] += rn[z] * v * vu[z] + b * au[z]
        for z in range(LANES):
            ea[z] += en[z] * a[z]
        for z in range(LANES):
            sa[z] += (weight * au[z] + pn[z]) * a[z]
        for z in range(LANES):
            xa[z] += b * a[z]
        for z in range(LANES):
            ra[z] += rn[z] * v * a[z]


@njit(**_INNER)
def _spread(i, first, x, u, w, of_joint, total, out):  # type: ignore[no-untyped-def]
    """Add K a of these centres to out[i]."""
    e, p, r = of_joint[0], of_joint[1], of_joint[2]
    # What e, p − x̄, ū, r∘qd' and r∘a, and w∘a are multiplied by takes the place of the sums.
    for z in range(LANES):
        k, cx, cu, cxu = np.exp(total[0, z]), total[1, z], total[2, z], total[3, z]
        ea, xa = total[4, z], total[6, z]
        ba = cu * ea - total[5, z]
        ya = cu * xa - total[7, z]
        total[0, z] = k * (cx * ba - cxu * ea - ya)
        total[1, z] = k * ba
        total[2, z] = k * (xa - cx * ea)
        total[3, z] = k * ea
        total[4, z] = k
        total[5, z] = k * (cxu - cx * cu)
    of_e, of_p, of_u, of_v, of_a, of_w = total[0], total[1], total[2], total[3], total[4], total[5]
    last = first + LANES
    for n in range(w.shape[0]):
        weight, b = w[n], w[n] * x[2][i, n]
        vu, au, a = u[1, n, first:last], u[2, n, first:last], u[5, n, first:last]
        en, pn, rn = e[n], p[n], r[n]
        torque = 0.0
        for z in range(LANES):
            torque += (
                of_e[z] * en[z]
                + of_p[z] * (pn[z] - b)
                + of_u[z] * weight * au[z]
                + rn[z] * (of_a[z] * a[z] - of_v[z] * vu[z])
                + of_w[z] * weight * a[z]
            )
        out[i, n] += torque
