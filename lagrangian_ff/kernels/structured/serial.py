"""The kinetic part of a serial arm: what its mass matrix can depend on, and on nothing else.

Entry (j, k), j ≤ k, of the mass matrix collects the links i ≥ k. Seen from joint j, link i moves
with the angles of the joints j+1 .. i only: with first degree in cosine and sine of those up to k,
of second degree in those beyond, since two Jacobian columns are multiplied there. A kernel that
says so, each entry apart, is ½ Σ_jk t_j t_k F_jk with t_j = Λ_j qd_j qd'_j and

    F_jk = Π_{j<l≤k} c_l · H_k,      H_k = κ_k + c²_{k+1} H_{k+1},      j ≤ k,

where κ_i is the weight of link i and c_l the factor of joint l. With w = Λ qd', b = Λ qdd', v = qd,
a = qdd, F^v and F^u the derivatives of F along qd and qd' (in d), the push-forward (22) is

    δ_nm Λ_n Σ_k (b_k (F_nk a_k + F^v_nk v_k) − w_k (F^u_nk a_k + F^vu_nk v_k))
    + Λ_m (b_n (F_nm a_m + F^v_nm v_m) − w_n (F^u_nm a_m + F^vu_nm v_m))
    − Λ_m v_m Σ_k ∂_n (F_mk b_k v_k − F^u_mk w_k v_k)
    + w_n Σ_k ∂_m (F_nk w_k a_k + F^v_nk w_k v_k)
    − ½ ∂_n ∂_m Σ_jk F_jk w_j v_j w_k v_k.

Sums over k are recursions along the chain, so that a block costs O(N²), as much as writing it:

    Σ_k t_k F_mk = P_m H_m + S_m,
    P_m = c_m (t_{m−1} + P_{m−1}),      S_m = t_m H_m + c_{m+1} S_{m+1}.

Beside a value x stand its changes in time, xv on the left and xu on the right: those of t with the
acceleration, those of F and H along the velocity. The factors c_l and their squares e_l = c_l² come
apart: every term has one of the two of a joint, once, or none, so that K is affine in each joint's.
"""

from numba import njit

from lagrangian_ff.kernels.options import APART_INNER


@njit(**APART_INNER)
def _products(v, a, vu, au, inertia, w, b, t, tv, tu):  # type: ignore[no-untyped-def]
    """Write Λ qd', Λ qdd', t and its changes; that on the right with the sign it has in d."""
    joints, lanes = vu.shape
    for n in range(joints):
        for z in range(lanes):
            w[n, z] = inertia[n] * vu[n, z]
            b[n, z] = inertia[n] * au[n, z]
            t[n, z] = w[n, z] * v[n]
            tv[n, z] = w[n, z] * a[n]
            tu[n, z] = -b[n, z] * v[n]


@njit(**APART_INNER)
def _heads(v, vu, c, t, tv, tu, p, pv, pu):  # type: ignore[no-untyped-def]
    """Write P."""
    joints, lanes = vu.shape
    for z in range(lanes):
        p[0, z] = pv[0, z] = pu[0, z] = 0.0
    for m in range(1, joints):
        x = v[m]
        for z in range(lanes):
            y = t[m - 1, z] + p[m - 1, z]
            p[m, z] = c[m, 0, z] * y
            pv[m, z] = c[m, 0, z] * (tv[m - 1, z] + pv[m - 1, z]) + c[m, 1, z] * x * y
            pu[m, z] = c[m, 0, z] * (tu[m - 1, z] + pu[m - 1, z]) + c[m, 1, z] * vu[m, z] * y


@njit(**APART_INNER)
def _tails(v, vu, e, link, h, hv, hu, hvu):  # type: ignore[no-untyped-def]
    """Write H."""
    joints, lanes = vu.shape
    for z in range(lanes):
        h[joints - 1, z] = link[joints - 1]
        hv[joints - 1, z] = hu[joints - 1, z] = hvu[joints - 1, z] = 0.0
    for k in range(joints - 1, 0, -1):
        x, weight = v[k], link[k - 1]
        for z in range(lanes):
            e0, e1, y = e[k, 0, z], e[k, 1, z], vu[k, z]
            below, below_v, below_u = h[k, z], hv[k, z], hu[k, z]
            h[k - 1, z] = weight + e0 * below
            hv[k - 1, z] = e0 * below_v + e1 * x * below
            hu[k - 1, z] = e0 * below_u + e1 * y * below
            turned = x * below_u + y * below_v
            hvu[k - 1, z] = e0 * hvu[k, z] + e1 * turned + e[k, 2, z] * x * y * below


@njit(**APART_INNER)
def _sums(v, vu, c, t, tv, tu, h, hv, hu, s, sv, su):  # type: ignore[no-untyped-def]
    """Write S."""
    joints, lanes = vu.shape
    for m in range(joints - 1, -1, -1):
        for z in range(lanes):
            s[m, z] = t[m, z] * h[m, z]
            sv[m, z] = t[m, z] * hv[m, z] + tv[m, z] * h[m, z]
            su[m, z] = t[m, z] * hu[m, z] + tu[m, z] * h[m, z]
        if m < joints - 1:
            k = m + 1
            x = v[k]
            for z in range(lanes):
                c0, c1, below = c[k, 0, z], c[k, 1, z], s[k, z]
                s[m, z] += c0 * below
                sv[m, z] += c0 * sv[k, z] + c1 * x * below
                su[m, z] += c0 * su[k, z] + c1 * vu[k, z] * below


@njit(**APART_INNER)
def _entries(  # type: ignore[no-untyped-def]
    v, a, vu, c, w, b, inertia, h, hv, hu, hvu, diagonal, run, run_v, run_u, run_vu, out
):
    """Write the terms of F without its derivatives by joint, Σ_k on the diagonal."""
    joints, lanes = vu.shape
    for j in range(joints):
        for z in range(lanes):
            straight = h[j, z] * a[j] + hv[j, z] * v[j]
            turned = hu[j, z] * a[j] + hvu[j, z] * v[j]
            diagonal[j, z] = 2.0 * (b[j, z] * straight - w[j, z] * turned)
    for j in range(joints):
        for z in range(lanes):
            run[z] = 1.0
            run_v[z] = run_u[z] = run_vu[z] = 0.0
        for k in range(j + 1, joints):
            x = v[k]
            for z in range(lanes):
                c0, c1, y = c[k, 0, z], c[k, 1, z], vu[k, z]
                p, pv, pu = run[z], run_v[z], run_u[z]
                run[z] = p * c0
                run_v[z] = pv * c0 + p * c1 * x
                run_u[z] = pu * c0 + p * c1 * y
                run_vu[z] = run_vu[z] * c0 + c1 * (pv * y + pu * x) + p * c[k, 2, z] * x * y
                p, pv, pu = run[z], run_v[z], run_u[z]
                f = p * h[k, z]
                fv = pv * h[k, z] + p * hv[k, z]
                fu = pu * h[k, z] + p * hu[k, z]
                fvu = run_vu[z] * h[k, z] + pv * hu[k, z] + pu * hv[k, z] + p * hvu[k, z]
                straight, turned = f * a[k] + fv * x, fu * a[k] + fvu * x
                diagonal[j, z] += b[k, z] * straight - w[k, z] * turned
                out[j, k, z] = inertia[k] * (b[j, z] * straight - w[j, z] * turned)
                straight, turned = f * a[j] + fv * v[j], fu * a[j] + fvu * v[j]
                diagonal[k, z] += b[j, z] * straight - w[j, z] * turned
                out[k, j, z] = inertia[j] * (b[k, z] * straight - w[k, z] * turned)
    for j in range(joints):
        for z in range(lanes):
            out[j, j, z] = inertia[j] * diagonal[j, z]


@njit(**APART_INNER)
def _add_slopes_beyond(  # type: ignore[no-untyped-def]
    v, vu, c, e, inertia, w, t, tv, tu, h, hv, hu, p, pv, pu, s, sv, su, g, gv, gu, r, rv, ru, out
):
    """Add the derivatives of Σ_k t_k F_mk by the joints n > m.

    Args:
        g, gv, gu: (N, L) to work in: at n, ∂_n H_m.  r, rv, ru: likewise ∂_n S_m.
    """
    joints, lanes = vu.shape
    for k in range(joints - 1, 0, -1):
        m = k - 1
        x, own = v[k], inertia[m] * v[m]
        for z in range(lanes):
            c1, c2, e1, e2, y = c[k, 1, z], c[k, 2, z], e[k, 1, z], e[k, 2, z], vu[k, z]
            g[k, z] = e1 * h[k, z]
            gv[k, z] = e1 * hv[k, z] + e2 * x * h[k, z]
            gu[k, z] = e1 * hu[k, z] + e2 * y * h[k, z]
            r[k, z] = c1 * s[k, z]
            rv[k, z] = c1 * sv[k, z] + c2 * x * s[k, z]
            ru[k, z] = c1 * su[k, z] + c2 * y * s[k, z]
        for n in range(k + 1, joints):
            for z in range(lanes):
                c0, c1, e0, e1, y = c[k, 0, z], c[k, 1, z], e[k, 0, z], e[k, 1, z], vu[k, z]
                gv[n, z] = e0 * gv[n, z] + e1 * x * g[n, z]
                gu[n, z] = e0 * gu[n, z] + e1 * y * g[n, z]
                g[n, z] = e0 * g[n, z]
                rv[n, z] = c0 * rv[n, z] + c1 * x * r[n, z]
                ru[n, z] = c0 * ru[n, z] + c1 * y * r[n, z]
                r[n, z] = c0 * r[n, z]
        for n in range(k, joints):
            for z in range(lanes):
                r[n, z] += t[m, z] * g[n, z]
                rv[n, z] += t[m, z] * gv[n, z] + tv[m, z] * g[n, z]
                ru[n, z] += t[m, z] * gu[n, z] + tu[m, z] * g[n, z]
                out[m, n, z] += w[m, z] * (rv[n, z] + p[m, z] * gv[n, z] + pv[m, z] * g[n, z])
                out[n, m, z] += own * (ru[n, z] + p[m, z] * gu[n, z] + pu[m, z] * g[n, z])


@njit(**APART_INNER)
def _add_slopes_before(  # type: ignore[no-untyped-def]
    v, vu, c, e, inertia, w, t, tv, tu, h, hv, hu, p, pv, pu, s, r, rv, ru, square, bend, out
):
    """Add the derivatives of Σ_k t_k F_mk by the joints n ≤ m, and ½ the second ones of Q.

    Q = Σ_jk t_j t_k F_jk = Σ_m X_m H_m with X_m = t_m (t_m + 2 P_m), and Y_m = X_m + e_m Y_{m−1}
    gathers what H_m meets.

    Args:
        r, rv, ru: (N, L) to work in: at n, ∂_n P_m.  square: (L,) Y_m.  bend: (N, L) ∂_n Y_m.
    """
    joints, lanes = vu.shape
    for z in range(lanes):
        square[z] = t[0, z] * t[0, z]
    for m in range(1, joints):
        x, own = v[m], inertia[m] * v[m]
        for n in range(1, m):
            for z in range(lanes):
                c0, c1, y = c[m, 0, z], c[m, 1, z], vu[m, z]
                both = c1 * r[n, z] * s[m, z] + 0.5 * e[m, 1, z] * bend[n, z] * h[m, z]
                rv[n, z] = c0 * rv[n, z] + c1 * x * r[n, z]
                ru[n, z] = c0 * ru[n, z] + c1 * y * r[n, z]
                r[n, z] = c0 * r[n, z]
                bend[n, z] = e[m, 0, z] * bend[n, z] + 2.0 * t[m, z] * r[n, z]
                change = r[n, z] * hv[m, z] + rv[n, z] * h[m, z]
                out[m, n, z] += w[m, z] * change - both
                change = r[n, z] * hu[m, z] + ru[n, z] * h[m, z]
                out[n, m, z] += own * change - both
        for z in range(lanes):
            c1, c2, y = c[m, 1, z], c[m, 2, z], vu[m, z]
            before = t[m - 1, z] + p[m - 1, z]
            r[m, z] = c1 * before
            rv[m, z] = c1 * (tv[m - 1, z] + pv[m - 1, z]) + c2 * x * before
            ru[m, z] = c1 * (tu[m - 1, z] + pu[m - 1, z]) + c2 * y * before
            bend[m, z] = 2.0 * t[m, z] * r[m, z] + e[m, 1, z] * square[z]
            left = w[m, z] * (r[m, z] * hv[m, z] + rv[m, z] * h[m, z])
            right = own * (r[m, z] * hu[m, z] + ru[m, z] * h[m, z])
            both = c2 * before * s[m, z] + 0.5 * e[m, 2, z] * square[z] * h[m, z]
            out[m, m, z] += left + right - both
            square[z] = t[m, z] * (t[m, z] + 2.0 * p[m, z]) + e[m, 0, z] * square[z]


@njit(**APART_INNER)
def kinetic(v, a, vu, au, c, e, inertia, link, work, out):  # type: ignore[no-untyped-def]
    """Write the blocks of one state with L others to out (N, N, L).

    Args:
        v, a: (N,) velocity and acceleration on the left.  vu, au: (N, L) and on the right.
        c, e: (N, 3, L) factors and their squares, each with its derivatives.
        inertia: (N,) Λ.  link: (N,) κ.
        work: (W, N or more, L) to work in.
    """
    w, b, t, tv, tu = work[0], work[1], work[2], work[3], work[4]
    h, hv, hu, hvu = work[5], work[6], work[7], work[8]
    p, pv, pu, s, sv, su = work[9], work[10], work[11], work[12], work[13], work[14]
    r, rv, ru, g, gv, gu = work[15], work[16], work[17], work[18], work[19], work[20]
    _products(v, a, vu, au, inertia, w, b, t, tv, tu)
    _heads(v, vu, c, t, tv, tu, p, pv, pu)
    _tails(v, vu, e, link, h, hv, hu, hvu)
    _sums(v, vu, c, t, tv, tu, h, hv, hu, s, sv, su)
    _entries(
        v, a, vu, c, w, b, inertia, h, hv, hu, hvu, r, rv[0], ru[0], g[0], gv[0], out
    )  # fmt: skip
    _add_slopes_beyond(
        v, vu, c, e, inertia, w, t, tv, tu, h, hv, hu, p, pv, pu, s, sv, su, g, gv, gu, r, rv, ru,
        out,
    )  # fmt: skip
    _add_slopes_before(
        v, vu, c, e, inertia, w, t, tv, tu, h, hv, hu, p, pv, pu, s, r, rv, ru, g[0], gv, out
    )  # fmt: skip
