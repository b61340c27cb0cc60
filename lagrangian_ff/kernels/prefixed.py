"""Compiled loops of the kernel of a serial chain: one pair of states at a time.

Joint i of a serial arm moves the links behind it by (q_1 .. q_i) only, so that the Lagrangian is a
sum over the prefixes i = 1 .. N of functions of the first i joints, each quadratic in velocity:

    k_L = Σ_i (½ s_i² + λ) h_i,    s_i = Σ_{j≤i} Λ_j qd_j qd'_j,
    h_i = Π_{j≤i} ((1 + ω cos(q_j − q'_j)) / (1 + ω))²,

plus the rotors ¼ ρ Σ_j (Λ_j qd_j qd'_j)². With r_j and e_j the first and second derivative of log h
in d_j = q_j − q'_j, a = qdd, and inner products over the prefix

    s = Λ v·v', s_b = Λ v·a', s_a = Λ a·v', s_ab = Λ a·a', r_v = r·v, r_w = r·v', g = e·(v∘v'),

the push-forward (22) of ½ s² h through T_n,x T_m,u is h times

    δ_nm Λ_n (s_ab + s_b r_v − s_a r_w − s (r_v r_w + g))
    + Λ_n (a'_n − v'_n r_w) Λ_m a_m
    + Λ_n (a'_n r_v − v'_n (r_v r_w + g)) Λ_m v_m
    + Λ_n v'_n (s_a r_m + s (r_m r_v + e_m v_m))
    − (s_b r_n − s (r_n r_w + e_n v'_n)) Λ_m v_m
    − ½ s² (r_n r_m + δ_nm e_n),

and that of λ h is −λ h (r_n r_m + δ_nm e_n). All sums run on from one prefix to the next.
"""

from typing import Any

import numpy as np
from numba import njit

_OPTIONS: dict[str, Any] = {
    "cache": True,
    "nogil": True,
    "error_model": "numpy",
    "fastmath": {"contract", "nsz"},
}


@njit(**_OPTIONS, inline="always")
def _wave(i, j, n, x, u, wave, scale):  # type: ignore[no-untyped-def]
    """The factor of joint n in h, and the first two derivatives of its logarithm."""
    cosine = x[4][i, n] * u[4][j, n] + x[3][i, n] * u[3][j, n]
    sine = x[3][i, n] * u[4][j, n] - x[4][i, n] * u[3][j, n]
    base = 1.0 + wave * cosine
    first = -2.0 * wave * sine / base
    second = -2.0 * wave * (cosine * base + wave * sine * sine) / (base * base)
    return (base * scale) ** 2, first, second


@njit(**_OPTIONS, inline="always")
def _block(i, j, x, u, inertia, potential, wave, rotor, r, e, block):  # type: ignore[no-untyped-def]
    """Write the N × N block K(x_i, u_j)."""
    joints = inertia.shape[0]
    scale = 1.0 / (1.0 + wave)
    block[:, :] = 0.0
    h = 1.0
    s, sb, sa, sab, rv, rw, g = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for last in range(joints):
        factor, first, second = _wave(i, j, last, x, u, wave, scale)
        h *= factor
        r[last] = first
        e[last] = second
        lv, la = inertia[last] * x[1][i, last], inertia[last] * x[2][i, last]
        v, w, b = x[1][i, last], u[1][j, last], u[2][j, last]
        s += lv * w
        sb += lv * b
        sa += la * w
        sab += la * b
        rv += first * v
        rw += first * w
        g += second * v * w
        bent = rv * rw + g
        diagonal = h * (sab + sb * rv - sa * rw - s * bent)
        stiff = 0.5 * s * s + potential
        for n in range(last + 1):
            ln, wn, bn = inertia[n], u[1][j, n], u[2][j, n]
            with_a = h * ln * (bn - wn * rw)
            with_v = h * (ln * (bn * rv - wn * bent) - (sb * r[n] - s * (r[n] * rw + e[n] * wn)))
            with_r = h * (ln * wn * (sa + s * rv) - stiff * r[n])
            with_e = h * ln * wn * s
            for m in range(last + 1):
                lm = inertia[m]
                block[n, m] += (
                    with_a * lm * x[2][i, m]
                    + with_v * lm * x[1][i, m]
                    + with_r * r[m]
                    + with_e * e[m] * x[1][i, m]
                )
            block[n, n] += ln * diagonal - h * stiff * e[n]
    for n in range(joints):
        block[n, n] += rotor * inertia[n] * inertia[n] * x[2][i, n] * u[2][j, n]


@njit(**_OPTIONS)
def gram_lower(x, inertia, potential, wave, rotor, out):  # type: ignore[no-untyped-def]
    """Write the lower triangle (by blocks) of the coupled Gram matrix, (M N, M N)."""
    joints = inertia.shape[0]
    r, e = np.empty(joints), np.empty(joints)
    block = np.empty((joints, joints))
    for i in range(x[0].shape[0]):
        for j in range(i + 1):
            _block(i, j, x, x, inertia, potential, wave, rotor, r, e, block)
            for n in range(joints):
                for m in range(joints):
                    out[i * joints + n, j * joints + m] = block[n, m]


@njit(**_OPTIONS)
def cross_blocks(x, u, inertia, potential, wave, rotor, out):  # type: ignore[no-untyped-def]
    """Write K(x_i, u_j)_nm to out[i, n, j, m]."""
    joints = inertia.shape[0]
    r, e = np.empty(joints), np.empty(joints)
    block = np.empty((joints, joints))
    for i in range(x[0].shape[0]):
        for j in range(u[0].shape[0]):
            _block(i, j, x, u, inertia, potential, wave, rotor, r, e, block)
            for n in range(joints):
                for m in range(joints):
                    out[i, n, j, m] = block[n, m]


@njit(**_OPTIONS)
def variances(x, inertia, potential, wave, rotor, out):  # type: ignore[no-untyped-def]
    """Write the diagonal of every K(x_i, x_i)."""
    joints = inertia.shape[0]
    r, e = np.empty(joints), np.empty(joints)
    block = np.empty((joints, joints))
    for i in range(x[0].shape[0]):
        _block(i, i, x, x, inertia, potential, wave, rotor, r, e, block)
        for n in range(joints):
            out[i, n] = block[n, n]


@njit(**_OPTIONS)
def apply_blocks(x, u, inertia, potential, wave, rotor, c, out):  # type: ignore[no-untyped-def]
    """Write Σ_j K(x_i, u_j) c_j to out[i]: inner products with c replace the blocks."""
    joints = inertia.shape[0]
    scale = 1.0 / (1.0 + wave)
    r, e = np.empty(joints), np.empty(joints)
    for i in range(x[0].shape[0]):
        for n in range(joints):
            out[i, n] = 0.0
        for j in range(u[0].shape[0]):
            h = 1.0
            s, sb, sa, sab, rv, rw, g = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
            ac, vc, rc, ec = 0.0, 0.0, 0.0, 0.0
            for last in range(joints):
                factor, first, second = _wave(i, j, last, x, u, wave, scale)
                h *= factor
                r[last] = first
                e[last] = second
                lv, la = inertia[last] * x[1][i, last], inertia[last] * x[2][i, last]
                v, w, b, c_last = x[1][i, last], u[1][j, last], u[2][j, last], c[j, last]
                s += lv * w
                sb += lv * b
                sa += la * w
                sab += la * b
                rv += first * v
                rw += first * w
                g += second * v * w
                ac += la * c_last
                vc += lv * c_last
                rc += first * c_last
                ec += second * v * c_last
                bent = rv * rw + g
                diagonal = sab + sb * rv - sa * rw - s * bent
                stiff = 0.5 * s * s + potential
                along = (sa + s * rv) * rc + s * ec
                for n in range(last + 1):
                    ln, wn, bn = inertia[n], u[1][j, n], u[2][j, n]
                    out[i, n] += h * (
                        ln
                        * (
                            (bn - wn * rw) * ac
                            + (bn * rv - wn * bent) * vc
                            + wn * along
                            + diagonal * c[j, n]
                        )
                        - (sb * r[n] - s * (r[n] * rw + e[n] * wn)) * vc
                        - stiff * (r[n] * rc + e[n] * c[j, n])
                    )
            for n in range(joints):
                own = rotor * inertia[n] * inertia[n]
                out[i, n] += own * x[2][i, n] * u[2][j, n] * c[j, n]
