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

Sums over k are recursions along the chain, so that a block costs O(N²), as much as writing it. A
pair (z0, z1) stands for z0 + z1 ε with ε² = 0: derivatives along a velocity ride with the value.
"""

from numba import njit

from lagrangian_ff.kernels.structured.options import INNER, LANES


@njit(**INNER)
def _sums(z0, z1, rate, c, h0, h1, g0, g1, p0, p1, s0, s1, out):  # type: ignore[no-untyped-def]
    """Write ∂_n of the ε part of Σ_k z_k F_mk to out[m, n], n ≥ 1.

    Args:
        z0, z1: (N, L) each.  rate: (N, L) the velocity that ε stands for.
        c: (3, N, L).  h0, h1: (N, L) H.  g0, g1: (N, N, L) ∂_n H_m at [m, n], n > m.
        p0, p1: (N, N, L): left at [m, 0] P_m = Σ_{k<m} z_k Π_{k<l≤m} c_l, at [m, n] ∂_n P_m.
        s0, s1: (N, N, L): left at [m, 0] S_m = Σ_{k≥m} z_k F_mk, at [m, n] ∂_n S_m.
    """
    joints = c.shape[1]
    last = joints - 1
    for z in range(LANES):
        p0[0, 0, z] = 0.0
        p1[0, 0, z] = 0.0
    for m in range(1, joints):
        for z in range(LANES):
            y0 = z0[m - 1, z] + p0[m - 1, 0, z]
            y1 = z1[m - 1, z] + p1[m - 1, 0, z]
            p0[m, 0, z] = c[0, m, z] * y0
            p1[m, 0, z] = c[0, m, z] * y1 + c[1, m, z] * rate[m, z] * y0
            p0[m, m, z] = c[1, m, z] * y0
            p1[m, m, z] = c[1, m, z] * y1 + c[2, m, z] * rate[m, z] * y0
        for n in range(1, m):
            for z in range(LANES):
                before = p0[m - 1, n, z]
                p0[m, n, z] = c[0, m, z] * before
                p1[m, n, z] = c[0, m, z] * p1[m - 1, n, z] + c[1, m, z] * rate[m, z] * before
        for n in range(1, m + 1):
            for z in range(LANES):
                out[m, n, z] = p0[m, n, z] * h1[m, z] + p1[m, n, z] * h0[m, z]
    for z in range(LANES):
        s0[last, 0, z] = z0[last, z] * h0[last, z]
        s1[last, 0, z] = z0[last, z] * h1[last, z] + z1[last, z] * h0[last, z]
    for m in range(last - 1, -1, -1):
        k = m + 1
        for z in range(LANES):
            below0, below1 = s0[k, 0, z], s1[k, 0, z]
            turn, bend = c[1, k, z] * rate[k, z], c[2, k, z] * rate[k, z]
            s0[m, 0, z] = z0[m, z] * h0[m, z] + c[0, k, z] * below0
            s1[m, 0, z] = (
                z0[m, z] * h1[m, z] + z1[m, z] * h0[m, z] + c[0, k, z] * below1 + turn * below0
            )
            s0[m, k, z] = z0[m, z] * g0[m, k, z] + c[1, k, z] * below0
            s1[m, k, z] = (
                z0[m, z] * g1[m, k, z] + z1[m, z] * g0[m, k, z] + c[1, k, z] * below1
                + bend * below0
            )  # fmt: skip
            out[m, k, z] = s1[m, k, z] + p0[m, 0, z] * g1[m, k, z] + p1[m, 0, z] * g0[m, k, z]
        for n in range(k + 1, joints):
            for z in range(LANES):
                below = s0[k, n, z]
                s0[m, n, z] = z0[m, z] * g0[m, n, z] + c[0, k, z] * below
                s1[m, n, z] = (
                    z0[m, z] * g1[m, n, z] + z1[m, z] * g0[m, n, z] + c[0, k, z] * s1[k, n, z]
                    + c[1, k, z] * rate[k, z] * below
                )  # fmt: skip
                out[m, n, z] = s1[m, n, z] + p0[m, 0, z] * g1[m, n, z] + p1[m, 0, z] * g0[m, n, z]


@njit(**INNER)
def _tails(v, vu, c, link, h, hv, hu, hvu, g, gv, gu):  # type: ignore[no-untyped-def]
    """H with its derivatives along the velocities, (N, L), and ∂_n H_m, (N, N, L)."""
    joints = v.shape[0]
    last = joints - 1
    for z in range(LANES):
        h[last, z] = link[last]
        hv[last, z] = hu[last, z] = hvu[last, z] = 0.0
    for m in range(last - 1, -1, -1):
        k = m + 1
        x = v[k]
        for z in range(LANES):
            c0, c1 = c[0, k, z], c[1, k, z]
            e, rise, curve = c0 * c0, 2.0 * c0 * c1, 2.0 * (c1 * c1 + c0 * c[2, k, z])
            y = vu[k, z]
            below, below_v, below_u = h[k, z], hv[k, z], hu[k, z]
            h[m, z] = link[m] + e * below
            hv[m, z] = e * below_v + rise * x * below
            hu[m, z] = e * below_u + rise * y * below
            hvu[m, z] = e * hvu[k, z] + rise * (x * below_u + y * below_v) + curve * x * y * below
            g[m, k, z] = rise * below
            gv[m, k, z] = rise * below_v + curve * x * below
            gu[m, k, z] = rise * below_u + curve * y * below
        for n in range(k + 1, joints):
            for z in range(LANES):
                e, rise = c[0, k, z] * c[0, k, z], 2.0 * c[0, k, z] * c[1, k, z]
                g[m, n, z] = e * g[k, n, z]
                gv[m, n, z] = e * gv[k, n, z] + rise * x * g[k, n, z]
                gu[m, n, z] = e * gu[k, n, z] + rise * vu[k, z] * g[k, n, z]


@njit(**INNER)
def _entries(  # type: ignore[no-untyped-def]
    v, a, vu, c, w, b, inertia, h, hv, hu, hvu, diagonal, run, run_v, run_u, run_vu, out
):
    """The terms of F without its derivatives by joint: write them to out, and Σ_k to diagonal."""
    joints = v.shape[0]
    for j in range(joints):
        for z in range(LANES):
            straight = h[j, z] * a[j] + hv[j, z] * v[j]
            turned = hu[j, z] * a[j] + hvu[j, z] * v[j]
            diagonal[j, z] = b[j, z] * straight - w[j, z] * turned
            out[j, j, z] = inertia[j] * diagonal[j, z]
    for j in range(joints):
        for z in range(LANES):
            run[z] = 1.0
            run_v[z] = run_u[z] = run_vu[z] = 0.0
        for k in range(j + 1, joints):
            x = v[k]
            for z in range(LANES):
                c0, c1, y = c[0, k, z], c[1, k, z], vu[k, z]
                p, pv, pu = run[z], run_v[z], run_u[z]
                run[z] = p * c0
                run_v[z] = pv * c0 + p * c1 * x
                run_u[z] = pu * c0 + p * c1 * y
                run_vu[z] = run_vu[z] * c0 + c1 * (pv * y + pu * x) + p * c[2, k, z] * x * y
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


@njit(**INNER)
def _bend(t, c, h, p0, s0, square, slope, out):  # type: ignore[no-untyped-def]
    """Subtract half the second derivatives of Q = Σ_jk t_j t_k F_jk from out.

    Q = Σ_m X_m H_m with X_m = t_m (t_m + 2 P_m); Y_m = X_m + c_m² Y_{m−1} gathers what H_m meets.
    """
    joints = c.shape[1]
    for z in range(LANES):
        square[0, z] = t[0, z] * t[0, z]
    for m in range(1, joints):
        for z in range(LANES):
            c0, c1, before = c[0, m, z], c[1, m, z], square[m - 1, z]
            rise, curve = 2.0 * c0 * c1, 2.0 * (c1 * c1 + c0 * c[2, m, z])
            y = t[m - 1, z] + p0[m - 1, 0, z]
            out[m, m, z] -= c[2, m, z] * y * s0[m, 0, z] + 0.5 * curve * before * h[m, z]
            slope[m, m, z] = 2.0 * t[m, z] * p0[m, m, z] + rise * before
            square[m, z] = t[m, z] * (t[m, z] + 2.0 * p0[m, 0, z]) + c0 * c0 * before
        for n in range(1, m):
            for z in range(LANES):
                c0, c1 = c[0, m, z], c[1, m, z]
                both = c1 * (p0[m - 1, n, z] * s0[m, 0, z] + c0 * slope[m - 1, n, z] * h[m, z])
                out[n, m, z] -= both
                out[m, n, z] -= both
                slope[m, n, z] = 2.0 * t[m, z] * p0[m, n, z] + c0 * c0 * slope[m - 1, n, z]


@njit(**INNER)
def kinetic(v, a, vu, au, c, inertia, link, work, square, out):  # type: ignore[no-untyped-def]
    """Write the blocks of one state with L others to out (N, N, L).

    Args:
        v, a: (N,) velocity and acceleration on the left.  vu, au: (N, L) and on the right.
        c: (3, N, L) factors and their derivatives.
        inertia: (N,) Λ.  link: (N,) κ.
        work: (W, N, L), square: (S, N, N, L), to work in.
    """
    joints = v.shape[0]
    w, b, t, wa, minus, bv, left = work[0], work[1], work[2], work[3], work[4], work[5], work[6]
    h, hv, hu, hvu, diagonal = work[7], work[8], work[9], work[10], work[11]
    g, gv, gu, sums = square[0], square[1], square[2], square[3]
    p0, p1, s0, s1 = square[4], square[5], square[6], square[7]
    for n in range(joints):
        for z in range(LANES):
            w[n, z] = inertia[n] * vu[n, z]
            b[n, z] = inertia[n] * au[n, z]
            t[n, z] = w[n, z] * v[n]
            wa[n, z] = w[n, z] * a[n]
            minus[n, z] = -t[n, z]
            bv[n, z] = b[n, z] * v[n]
            left[n, z] = v[n]
    _tails(v, vu, c, link, h, hv, hu, hvu, g, gv, gu)
    run, run_v, run_u, run_vu = work[12][0], work[13][0], work[14][0], work[15][0]
    _entries(
        v, a, vu, c, w, b, inertia, h, hv, hu, hvu, diagonal, run, run_v, run_u, run_vu, out
    )  # fmt: skip
    _sums(minus, bv, vu, c, h, hu, g, gu, p0, p1, s0, s1, sums)
    for m in range(joints):
        for n in range(1, joints):
            for z in range(LANES):
                out[n, m, z] -= inertia[m] * v[m] * sums[m, n, z]
    _sums(t, wa, left, c, h, hv, g, gv, p0, p1, s0, s1, sums)
    for m in range(joints):
        for n in range(1, joints):
            for z in range(LANES):
                out[m, n, z] += w[m, z] * sums[m, n, z]
        for z in range(LANES):
            out[m, m, z] += inertia[m] * diagonal[m, z]
    _bend(t, c, h, p0, s0, work[12], s1, out)
