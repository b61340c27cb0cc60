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

from lagrangian_ff.kernels import threads
from lagrangian_ff.kernels.base import Learned
from lagrangian_ff.kernels.compiled import prepared
from lagrangian_ff.kernels.exponential import exponentials
from lagrangian_ff.kernels.options import APART, APART_INNER
from lagrangian_ff.kernels.states import States

Floats = NDArray[np.float64]

LANES = 64
"""Centres that a loop runs over before the next one does: few enough to stay in the nearest
memory, and enough to be worth the call."""

PAIRS_A_BLOCK = 40
"""Pairs that cost as much here as one of those that `threads` counts."""


@dataclass(frozen=True)
class SideBySide(Learned):
    """Torques learned at centres that lie joint by joint, so that loops over them are fast.

    Attributes:
        centres: (C / L, N, 5, L) of each the sine and cosine of the position, or it and 1 where the
            coordinate is linear, and qd, qdd and a.
        weights: which coordinates are angles, α and w of `fused`.
    """

    centres: Floats
    weights: tuple[Any, Floats, Floats]

    @classmethod
    def of(cls, u: States, a: Floats, weights: tuple[Any, Floats, Floats]) -> "SideBySide":
        """What was learned at u (C, N) with coefficients a (C, N)."""
        q, qd, qdd, sine, cosine = prepared(u)
        angle = weights[0]
        place = np.where(angle, sine, q), np.where(angle, cosine, 1.0)
        parts = -(-len(u) // LANES)
        centres = np.zeros((5, parts * LANES, u.joints))
        centres[:, : len(u)] = *place, qd, qdd, a
        lanes = centres.reshape(5, parts, LANES, u.joints)
        return cls(np.ascontiguousarray(lanes.transpose(1, 3, 0, 2)), weights)

    def torque(self, x: States) -> Floats:
        """See `Learned.torque`."""
        out = np.empty(x.q.shape)
        states = prepared(x)

        def write(rows: slice) -> None:
            part = tuple(values[rows] for values in states)
            _apply(part, self.centres, *self.weights, out[rows])

        pairs = len(x) * self.centres.shape[0] * LANES
        threads.over_rows(write, len(x), pairs / PAIRS_A_BLOCK)
        return out


@njit(**APART)
def _apply(x, centres, angle, alpha, w, out):  # type: ignore[no-untyped-def]
    """Write Σ_j K(x_i, u_j) a_j to out[i]."""
    joints = w.shape[0]
    e, p, r = np.empty((joints, LANES)), np.empty((joints, LANES)), np.empty((joints, LANES))
    total, work = np.empty((8, LANES)), np.empty((2, LANES))
    for i in range(x[0].shape[0]):
        out[i, :] = 0.0
        for part in range(centres.shape[0]):
            total[:, :] = 0.0
            for n in range(joints):
                place = _place(i, n, x, angle, alpha)
                _gather(
                    place, x[1][i, n], x[2][i, n], w[n], centres[part, n], e[n], p[n], r[n],
                    total[0], total[1], total[2], total[3], total[4], total[5], total[6], total[7],
                )  # fmt: skip
            exponentials(total[0], work[0], work[1])
            _combine(
                work[1],
                total[0], total[1], total[2], total[3], total[4], total[5], total[6], total[7],
            )  # fmt: skip
            for n in range(joints):
                out[i, n] += _spread(
                    x[2][i, n], w[n], centres[part, n], e[n], p[n], r[n],
                    total[0], total[1], total[2], total[3], total[4], total[5],
                )  # fmt: skip


@njit(**APART_INNER)
def _place(i, n, x, angle, alpha):  # type: ignore[no-untyped-def]
    """Where joint n of state i is, as `_gather` takes it.

    p is the first times the centre's second less the second times its first, r the second times its
    second plus the third times its first, and −½ ρ = r − α − bend p².
    """
    scale = alpha[n]
    if angle[n]:
        sine = scale * x[3][i, n]
        return sine, scale * x[4][i, n], sine, scale, 0.0
    return scale * x[0][i, n], scale, 0.0, scale, 0.5 / scale


@njit(**APART_INNER)
def _gather(  # type: ignore[no-untyped-def]
    place, v, acceleration, w, centres, e, p, r, log_k, cx, cu, cxu, ea, sa, xa, ra
):
    """Write e, p and r of a joint, and add what it contributes to the sums; sa is U + P."""
    sine, cosine, turn, alpha, bend = place
    sines, cosines, vu, au, a = centres[0], centres[1], centres[2], centres[3], centres[4]
    b = w * acceleration
    for z in range(LANES):
        pz = sine * cosines[z] - cosine * sines[z]
        rz = cosine * cosines[z] + turn * sines[z]
        difference = v - vu[z]
        ez = w * difference
        log_k[z] += rz - alpha - bend * pz * pz - 0.5 * ez * difference
        cx[z] += pz * v + ez * acceleration
        cu[z] += pz * vu[z] + ez * au[z]
        cxu[z] += rz * v * vu[z] + b * au[z]
        ea[z] += ez * a[z]
        sa[z] += (w * au[z] + pz) * a[z]
        xa[z] += b * a[z]
        ra[z] += rz * v * a[z]
        e[z], p[z], r[z] = ez, pz, rz


@njit(**APART_INNER)
def _combine(k, of_e, of_p, of_u, of_v, of_a, of_w, xa, ra):  # type: ignore[no-untyped-def]
    """Replace log k, c_x, c_u, c_xu, E and U + P by what the terms are multiplied by.

    Those of e, p − x̄, ū, r∘qd', r∘a and w∘a.
    """
    for z in range(LANES):
        cx, cu, cxu, ea = of_p[z], of_u[z], of_v[z], of_a[z]
        ba = cu * ea - of_w[z]
        of_e[z] = k[z] * (cx * ba - cxu * ea - cu * xa[z] + ra[z])
        of_p[z] = k[z] * ba
        of_u[z] = k[z] * (xa[z] - cx * ea)
        of_v[z] = k[z] * ea
        of_a[z] = k[z]
        of_w[z] = k[z] * (cxu - cx * cu)


@njit(**APART_INNER)
def _spread(  # type: ignore[no-untyped-def]
    acceleration, w, centres, e, p, r, of_e, of_p, of_u, of_v, of_a, of_w
):
    """K a of these centres, of one joint."""
    vu, au, a = centres[2], centres[3], centres[4]
    b, torque = w * acceleration, 0.0
    for z in range(LANES):
        torque += (
            of_e[z] * e[z]
            + of_p[z] * (p[z] - b)
            + of_u[z] * w * au[z]
            + r[z] * (of_a[z] * a[z] - of_v[z] * vu[z])
            + of_w[z] * w * a[z]
        )
    return torque
