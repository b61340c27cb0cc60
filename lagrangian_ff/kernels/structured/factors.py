"""What one joint contributes to a product over joints: a function of d = q − q', and its slopes.

    cosine   (1 + ω cos d) / (1 + ω)       a polynomial of first degree in cosine and sine
    bell     exp(−ω (1 − cos d))           universal on the circle, eqs. (36), (38)
    line     exp(−½ ω d²)                  universal on the line, for a prismatic joint

Each is 1 at d = 0 and positive definite for every ω > 0.
"""

import numpy as np
from numba import njit

from lagrangian_ff.kernels.options import APART_INNER

COSINE, BELL, LINE = 0, 1, 2


@njit(**APART_INNER)
def factor(form, omega, x, i, u, lanes, n, c):  # type: ignore[no-untyped-def]
    """Write factor, first and second derivative in d of joint n to c (3, L).

    Args:
        form: one of the three.  omega: its ω.
        x, i: prepared states and the one on the left.  u, lanes: and those on the right.
        n: the joint.
    """
    if form == LINE:
        for z in range(c.shape[1]):
            d = x[0][i, n] - u[0][lanes[z], n]
            value = np.exp(-0.5 * omega * d * d)
            c[0, z] = value
            c[1, z] = -omega * d * value
            c[2, z] = omega * (omega * d * d - 1.0) * value
        return
    sine, cosine = x[3][i, n], x[4][i, n]
    for z in range(c.shape[1]):
        c[1, z] = sine * u[4][lanes[z], n] - cosine * u[3][lanes[z], n]
        c[2, z] = cosine * u[4][lanes[z], n] + sine * u[3][lanes[z], n]
    if form == COSINE:
        scale = 1.0 / (1.0 + omega)
        share = omega * scale
        for z in range(c.shape[1]):
            c[0, z] = scale + share * c[2, z]
            c[1, z] = -share * c[1, z]
            c[2, z] = -share * c[2, z]
        return
    for z in range(c.shape[1]):
        sin, cos = c[1, z], c[2, z]
        value = np.exp(omega * (cos - 1.0))
        c[0, z] = value
        c[1, z] = -omega * sin * value
        c[2, z] = omega * (omega * sin * sin - cos) * value


@njit(**APART_INNER)
def rate(form, omega, x, i, u, lanes, n, c, out):  # type: ignore[no-untyped-def]
    """Write the derivatives in ω of what `factor` wrote for joint n to out (3, L)."""
    if form == COSINE:
        scale = 1.0 / (omega * (1.0 + omega))
        for z in range(c.shape[1]):
            out[0, z] = (c[0, z] - 1.0) * scale
            out[1, z] = c[1, z] * scale
            out[2, z] = c[2, z] * scale
        return
    for z in range(c.shape[1]):
        value = c[0, z]
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
        out[2, z] = (2.0 * omega * rise * rise - bend) * value - b * c[2, z]


@njit(**APART_INNER)
def square(c, e):  # type: ignore[no-untyped-def]
    """Write the square of a factor c (3, L), and its derivatives in d, to e (3, L)."""
    for z in range(c.shape[1]):
        e[0, z] = c[0, z] * c[0, z]
        e[1, z] = 2.0 * c[0, z] * c[1, z]
        e[2, z] = 2.0 * (c[1, z] * c[1, z] + c[0, z] * c[2, z])


@njit(**APART_INNER)
def move(amount, rate, c, e, moved, moved_square):  # type: ignore[no-untyped-def]
    """Write what a factor c and its square e become, to first order, by an amount of a rate.

    Args:
        rate: (3, L) of the factor and its derivatives in d; all others likewise.
    """
    for z in range(c.shape[1]):
        c0, c1, c2 = c[0, z], c[1, z], c[2, z]
        d0, d1, d2 = amount * rate[0, z], amount * rate[1, z], amount * rate[2, z]
        moved[0, z], moved[1, z], moved[2, z] = c0 + d0, c1 + d1, c2 + d2
        moved_square[0, z] = e[0, z] + 2.0 * c0 * d0
        moved_square[1, z] = e[1, z] + 2.0 * (c0 * d1 + c1 * d0)
        moved_square[2, z] = e[2, z] + 2.0 * (2.0 * c1 * d1 + c0 * d2 + c2 * d0)


@njit(**APART_INNER)
def swap(one, other):  # type: ignore[no-untyped-def]
    """Exchange two factors (3, L)."""
    for d in range(3):
        for z in range(one.shape[1]):
            one[d, z], other[d, z] = other[d, z], one[d, z]
