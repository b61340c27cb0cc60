"""The kinetic part of an arm of any topology: ½ s² h, s = Σ_j Λ_j qd_j qd'_j, h = Π_l c_l(d_l)².

Every entry of the mass matrix may depend on every joint. With e_l = c_l², w = Λ qd', b = Λ qdd',
v = qd, a = qdd, subscripts of h its derivatives in d, and along qd and qd'

    h_v = Σ_l h_l v_l,   h_u = Σ_l h_l qd'_l,   h_vu = Σ_lm h_lm v_l qd'_m,

the push-forward (22) of the kernel is

    δ_nm Λ_n Σ_k (b_k (h a_k + h_v v_k) − w_k (h_u a_k + h_vu v_k))
    + Λ_m (b_n (h a_m + h_v v_m) − w_n (h_u a_m + h_vu v_m))
    − Λ_m v_m (h_n b·v − Σ_l h_nl qd'_l w·v) + w_n (h_m w·a + Σ_l h_ml v_l w·v)
    − ½ h_nm (w·v)².
"""

from numba import njit

from lagrangian_ff.kernels.options import APART_INNER


@njit(**APART_INNER)
def _sums(v, a, vu, au, inertia, w, b, wa, wv, ba, bv):  # type: ignore[no-untyped-def]
    """Write Λ qd', Λ qdd' and their products with velocity and acceleration on the left."""
    joints, lanes = vu.shape
    for z in range(lanes):
        wa[z] = wv[z] = ba[z] = bv[z] = 0.0
    for n in range(joints):
        for z in range(lanes):
            w[n, z] = inertia[n] * vu[n, z]
            b[n, z] = inertia[n] * au[n, z]
            wa[z] += w[n, z] * a[n]
            wv[z] += w[n, z] * v[n]
            ba[z] += b[n, z] * a[n]
            bv[z] += b[n, z] * v[n]


@njit(**APART_INNER)
def _bends(e, scale, h, head, tail, run, first, bend):  # type: ignore[no-untyped-def]
    """Write scale · h and its first and second derivatives, (N, L) and (N, N or more, L).

    Args:
        head, tail: (N, L) left as the products of the factors before and beyond each.
        run: (L,) to work in.
    """
    joints, _, lanes = e.shape
    for z in range(lanes):
        h[z] = scale
        tail[joints - 1, z] = 1.0
    for n in range(joints):
        for z in range(lanes):
            head[n, z] = h[z]
            h[z] *= e[n, 0, z]
    for n in range(joints - 1, 0, -1):
        for z in range(lanes):
            tail[n - 1, z] = tail[n, z] * e[n, 0, z]
    for n in range(joints):
        for z in range(lanes):
            run[z] = head[n, z] * e[n, 1, z]
            first[n, z] = run[z] * tail[n, z]
            bend[n, n, z] = head[n, z] * e[n, 2, z] * tail[n, z]
        for m in range(n + 1, joints):
            for z in range(lanes):
                both = run[z] * e[m, 1, z] * tail[m, z]
                bend[n, m, z] = both
                bend[m, n, z] = both
                run[z] *= e[m, 0, z]


@njit(**APART_INNER)
def _along(v, vu, first, bend, hv, hu, hvu, along_v, along_u):  # type: ignore[no-untyped-def]
    """Write the derivatives of h and of its first derivatives along the velocities."""
    joints, lanes = vu.shape
    for z in range(lanes):
        hv[z] = hu[z] = hvu[z] = 0.0
    for n in range(joints):
        for z in range(lanes):
            hv[z] += first[n, z] * v[n]
            hu[z] += first[n, z] * vu[n, z]
            along_v[n, z] = along_u[n, z] = 0.0
        for m in range(joints):
            for z in range(lanes):
                along_v[n, z] += bend[n, m, z] * v[m]
                along_u[n, z] += bend[n, m, z] * vu[m, z]
        for z in range(lanes):
            hvu[z] += along_v[n, z] * vu[n, z]


@njit(**APART_INNER)
def _write(  # type: ignore[no-untyped-def]
    v, a, inertia, w, b, wa, wv, ba, bv, h, hv, hu, hvu, first, along_v, along_u, bend, out
):
    """Write what the sums make to out."""
    joints, lanes = w.shape
    for n in range(joints):
        for m in range(joints):
            for z in range(lanes):
                straight = h[z] * a[m] + hv[z] * v[m]
                turned = hu[z] * a[m] + hvu[z] * v[m]
                fall = first[n, z] * bv[z] - along_u[n, z] * wv[z]
                rise = first[m, z] * wa[z] + along_v[m, z] * wv[z]
                out[n, m, z] = (
                    inertia[m] * (b[n, z] * straight - w[n, z] * turned - v[m] * fall)
                    + w[n, z] * rise
                    - 0.5 * bend[n, m, z] * wv[z] * wv[z]
                )
        for z in range(lanes):
            own = h[z] * ba[z] + hv[z] * bv[z] - hu[z] * wa[z] - hvu[z] * wv[z]
            out[n, n, z] += inertia[n] * own


@njit(**APART_INNER)
def kinetic(v, a, vu, au, e, inertia, link, work, out):  # type: ignore[no-untyped-def]
    """Write the blocks of one state with L others to out (N, N, L).

    Args:
        v, a: (N,) velocity and acceleration on the left.  vu, au: (N, L) and on the right.
        e: (N, 3, L) squares of the factors and their derivatives.
        inertia: (N,) Λ.  link: (N,), of which the last scales all.
        work: (W + N, N, L) to work in.
    """
    w, b, first, along_v, along_u = work[0], work[1], work[2], work[3], work[4]
    h, hv, hu, hvu = work[5, 0], work[6, 0], work[7, 0], work[8, 0]
    wa, wv, ba, bv = work[9, 0], work[10, 0], work[11, 0], work[12, 0]
    head, tail, bend = work[13], work[14], work[15:]
    _sums(v, a, vu, au, inertia, w, b, wa, wv, ba, bv)
    _bends(e, link[-1], h, head, tail, along_v[0], first, bend)
    _along(v, vu, first, bend, hv, hu, hvu, along_v, along_u)
    _write(
        v, a, inertia, w, b, wa, wv, ba, bv, h, hv, hu, hvu, first, along_v, along_u, bend, out
    )  # fmt: skip
