"""Compiled loops of the universal Lagrangian kernels (36), (37): one pair of states at a time.

The scalar kernel on the Lagrangian is k = exp(-½ Σ_j ρ_j(q_j − q'_j) − ½ Σ_j w_j (qd_j − qd'_j)²)
with ρ_j = α_j d² for a linear coordinate and 2 α_j (1 − cos d) for an angle, d = q_j − q'_j. Its
push-forward through the Euler-Lagrange operator on both arguments is *diagonal plus four outer
products*. With e = w∘(qd − qd'), x̄ = w∘qdd, ū = w∘qdd', p_j = ½ ∂ρ_j/∂d, r_j = ∂p_j/∂d and

    c_x  = p·qd  + e·qdd          (minus the rate of log k along the first motion)
    c_u  = p·qd' + e·qdd'         (the rate of log k along the second)
    c_xu = Σ_j r_j qd_j qd'_j + w_j qdd_j qdd'_j
    A    = c_x e − x̄ + p          (T_n,x k = k A_n)
    B    = c_u e − ū − p          (T_m,u k = k B_m, eq. (34))

it reads

    K / k = A Bᵀ + diag(r + (c_xu − c_x c_u) w)
            − (c_xu e + c_x ū + r∘qd') eᵀ − e (c_u x̄ − r∘qd)ᵀ + ū x̄ᵀ,

which equals eq. (37) of the paper with c_u read for its c_y, and ∂φ_u for the last factor of its
K_2. How it is applied to coefficients without forming a block is in `side_by_side`.
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
def _geometry(i, j, x, u, angle, alpha, w, e, p, r):  # type: ignore[no-untyped-def]
    """Fill e, p, r for one pair and return k, c_x, c_u, c_xu."""
    exponent = 0.0
    cx = 0.0
    cu = 0.0
    cxu = 0.0
    for n in range(w.shape[0]):
        if angle[n]:
            p[n] = alpha[n] * (x[3][i, n] * u[4][j, n] - x[4][i, n] * u[3][j, n])
            r[n] = alpha[n] * (x[4][i, n] * u[4][j, n] + x[3][i, n] * u[3][j, n])
            exponent += alpha[n] - r[n]
        else:
            d = x[0][i, n] - u[0][j, n]
            p[n] = alpha[n] * d
            r[n] = alpha[n]
            exponent += 0.5 * p[n] * d
        dv = x[1][i, n] - u[1][j, n]
        e[n] = w[n] * dv
        exponent += 0.5 * e[n] * dv
        cx += p[n] * x[1][i, n] + e[n] * x[2][i, n]
        cu += p[n] * u[1][j, n] + e[n] * u[2][j, n]
        cxu += r[n] * x[1][i, n] * u[1][j, n] + w[n] * x[2][i, n] * u[2][j, n]
    return np.exp(-exponent), cx, cu, cxu


@njit(**_OPTIONS, inline="always")
def _block(i, j, x, u, angle, alpha, w, e, p, r, block):  # type: ignore[no-untyped-def]
    """Write the N × N block K(x_i, u_j)."""
    k, cx, cu, cxu = _geometry(i, j, x, u, angle, alpha, w, e, p, r)
    joints = w.shape[0]
    for n in range(joints):
        an = k * (cx * e[n] - w[n] * x[2][i, n] + p[n])
        en = k * e[n]
        un = k * w[n] * u[2][j, n]
        left = cxu * en + cx * un + k * r[n] * u[1][j, n]
        for m in range(joints):
            xm = w[m] * x[2][i, m]
            block[n, m] = (
                an * (cu * e[m] - w[m] * u[2][j, m] - p[m])
                - left * e[m]
                - en * (cu * xm - r[m] * x[1][i, m])
                + un * xm
            )
        block[n, n] += k * (r[n] + w[n] * (cxu - cx * cu))


@njit(**_OPTIONS, inline="always")
def _diagonal(n, i, j, x, u, w, k, cx, cu, cxu, e, p, r):  # type: ignore[no-untyped-def]
    """The entry K_nn(x_i, u_j), the scalar Lagrangian kernel (30)."""
    xn = w[n] * x[2][i, n]
    un = w[n] * u[2][j, n]
    return k * (
        (cx * e[n] - xn + p[n]) * (cu * e[n] - un - p[n])
        - (cxu * e[n] + cx * un + r[n] * u[1][j, n]) * e[n]
        - e[n] * (cu * xn - r[n] * x[1][i, n])
        + un * xn
        + r[n]
        + w[n] * (cxu - cx * cu)
    )


@njit(**_OPTIONS)
def gram_lower(x, angle, alpha, w, out):  # type: ignore[no-untyped-def]
    """Write the lower triangle (by blocks) of the coupled Gram matrix, (M N, M N)."""
    joints = w.shape[0]
    e, p, r = np.empty(joints), np.empty(joints), np.empty(joints)
    block = np.empty((joints, joints))
    for i in range(x[0].shape[0]):
        for j in range(i + 1):
            _block(i, j, x, x, angle, alpha, w, e, p, r, block)
            for n in range(joints):
                for m in range(joints):
                    out[i * joints + n, j * joints + m] = block[n, m]


@njit(**_OPTIONS)
def cross_blocks(x, u, angle, alpha, w, out):  # type: ignore[no-untyped-def]
    """Write K(x_i, u_j)_nm to out[i, n, j, m]."""
    joints = w.shape[0]
    e, p, r = np.empty(joints), np.empty(joints), np.empty(joints)
    block = np.empty((joints, joints))
    for i in range(x[0].shape[0]):
        for j in range(u[0].shape[0]):
            _block(i, j, x, u, angle, alpha, w, e, p, r, block)
            for n in range(joints):
                for m in range(joints):
                    out[i, n, j, m] = block[n, m]


@njit(**_OPTIONS)
def lagrangian_rows(x, u, angle, alpha, w, out):  # type: ignore[no-untyped-def]
    """Write T_m,u k(x_i, u_j) to out[i, j, m], eq. (34)."""
    joints = w.shape[0]
    e, p, r = np.empty(joints), np.empty(joints), np.empty(joints)
    for i in range(x[0].shape[0]):
        for j in range(u[0].shape[0]):
            k, _, cu, _ = _geometry(i, j, x, u, angle, alpha, w, e, p, r)
            for m in range(joints):
                out[i, j, m] = k * (cu * e[m] - w[m] * u[2][j, m] - p[m])


@njit(**_OPTIONS)
def tell_lagrangian(x, u, angle, alpha, w, a, value, momentum):  # type: ignore[no-untyped-def]
    """Write L = Σ_j Σ_m T_m,u k(x_i, u_j) a_jm to value[i], and ∂L/∂qd to momentum[i]."""
    joints = w.shape[0]
    e, p, r = np.empty(joints), np.empty(joints), np.empty(joints)
    for i in range(x[0].shape[0]):
        value[i] = 0.0
        momentum[i, :] = 0.0
        for j in range(u[0].shape[0]):
            k, _, cu, _ = _geometry(i, j, x, u, angle, alpha, w, e, p, r)
            ba = 0.0
            ea = 0.0
            for m in range(joints):
                ba += (cu * e[m] - w[m] * u[2][j, m] - p[m]) * a[j, m]
                ea += e[m] * a[j, m]
            value[i] += k * ba
            for n in range(joints):
                momentum[i, n] += k * (w[n] * (u[2][j, n] * ea + cu * a[j, n]) - e[n] * ba)


@njit(**_OPTIONS)
def cross_diagonal(x, u, angle, alpha, w, joint, out):  # type: ignore[no-untyped-def]
    """Write the scalar kernel K_nn(x_i, u_j) of one joint n to out[i, j]."""
    joints = w.shape[0]
    e, p, r = np.empty(joints), np.empty(joints), np.empty(joints)
    for i in range(x[0].shape[0]):
        for j in range(u[0].shape[0]):
            k, cx, cu, cxu = _geometry(i, j, x, u, angle, alpha, w, e, p, r)
            out[i, j] = _diagonal(joint, i, j, x, u, w, k, cx, cu, cxu, e, p, r)


@njit(**_OPTIONS)
def apply_diagonal(x, u, angle, alpha, w, joint, a, out):  # type: ignore[no-untyped-def]
    """Write Σ_j K_nn(x_i, u_j) a_j of one joint n to out[i]."""
    joints = w.shape[0]
    e, p, r = np.empty(joints), np.empty(joints), np.empty(joints)
    for i in range(x[0].shape[0]):
        total = 0.0
        for j in range(u[0].shape[0]):
            k, cx, cu, cxu = _geometry(i, j, x, u, angle, alpha, w, e, p, r)
            total += _diagonal(joint, i, j, x, u, w, k, cx, cu, cxu, e, p, r) * a[j]
        out[i] = total


@njit(**_OPTIONS)
def variances(x, angle, alpha, w, out):  # type: ignore[no-untyped-def]
    """Write K_nn(x_i, x_i) to out[i, n]."""
    joints = w.shape[0]
    e, p, r = np.empty(joints), np.empty(joints), np.empty(joints)
    for i in range(x[0].shape[0]):
        k, cx, cu, cxu = _geometry(i, i, x, x, angle, alpha, w, e, p, r)
        for n in range(joints):
            out[i, n] = _diagonal(n, i, i, x, x, w, k, cx, cu, cxu, e, p, r)
