"""What one joint contributes to a product over joints: a function of d = q − q', and its slopes.

    cosine   (1 + ω cos d) / (1 + ω)       a polynomial of first degree in cosine and sine
    bell     exp(−ω (1 − cos d))           universal on the circle, eqs. (36), (38)
    line     exp(−½ ω d²)                  universal on the line, for a prismatic joint

Each is 1 at d = 0 and positive definite for every ω > 0.
"""

import numpy as np
from numba import njit

from lagrangian_ff.kernels.structured.options import INNER, LANES

COSINE, BELL, LINE = 0, 1, 2


@njit(**INNER)
def factor(form, omega, x, i, u, lanes, n, c):  # type: ignore[no-untyped-def]
    """Write factor, first and second derivative in d of joint n to c (3, N, L).

    Args:
        form: one of the three.  omega: its ω.
        x, i: prepared states and the one on the left.  u, lanes: and those on the right.
        n: the joint.
    """
    if form == LINE:
        for z in range(LANES):
            d = x[0][i, n] - u[0][lanes[z], n]
            value = np.exp(-0.5 * omega * d * d)
            c[0, n, z] = value
            c[1, n, z] = -omega * d * value
            c[2, n, z] = omega * (omega * d * d - 1.0) * value
        return
    sine, cosine = x[3][i, n], x[4][i, n]
    for z in range(LANES):
        c[1, n, z] = sine * u[4][lanes[z], n] - cosine * u[3][lanes[z], n]
        c[2, n, z] = cosine * u[4][lanes[z], n] + sine * u[3][lanes[z], n]
    if form == COSINE:
        scale = 1.0 / (1.0 + omega)
        share = omega * scale
        for z in range(LANES):
            c[0, n, z] = scale + share * c[2, n, z]
            c[1, n, z] = -share * c[1, n, z]
            c[2, n, z] = -share * c[2, n, z]
        return
    for z in range(LANES):
        sin, cos = c[1, n, z], c[2, n, z]
        value = np.exp(omega * (cos - 1.0))
        c[0, n, z] = value
        c[1, n, z] = -omega * sin * value
        c[2, n, z] = omega * (omega * sin * sin - cos) * value


@njit(**INNER)
def move(form, omega, amount, x, i, u, lanes, n, c, rate):  # type: ignore[no-untyped-def]
    """Add an amount of how joint n's factor and its two derivatives change with ω.

    Args:
        amount: of the rate.  rate: (3, L) to work in.
    """
    _rate(form, omega, x, i, u, lanes, n, c, rate)
    for d in range(3):
        for z in range(LANES):
            c[d, n, z] += amount * rate[d, z]


@njit(**INNER)
def _rate(form, omega, x, i, u, lanes, n, c, out):  # type: ignore[no-untyped-def]
    """Write the derivatives in ω of what `factor` wrote for joint n to out (3, L)."""
    if form == COSINE:
        scale = 1.0 / (omega * (1.0 + omega))
        for z in range(LANES):
            out[0, z] = (c[0, n, z] - 1.0) * scale
            out[1, z] = c[1, n, z] * scale
            out[2, z] = c[2, n, z] * scale
        return
    for z in range(LANES):
        value = c[0, n, z]
        # With value = exp(−ω b(d)): b, its slope and its curvature.
        if form == LINE:
            d = x[0][i, n] - u[0][lanes[z], n]
            b, rise, bend = 0.5 * d * d, d, 1.0
        else:
            sin = x[3][i, n] * u[4][lanes[z], n] - x[4][i, n] * u[3][lanes[z], n]
            cos = x[4][i, n] * u[4][lanes[z], n] + x[3][i, n] * u[3][lanes[z], n]
            b, rise, bend = 1.0 - cos, sin, cos
        out[0, z] = -b * value
        out[1, z] = rise * (omega * b - 1.0) * value
        out[2, z] = (2.0 * omega * rise * rise - bend) * value - b * c[2, n, z]
