"""The kinetic part of an arm of any topology: ½ s² h, s = Σ_j Λ_j qd_j qd'_j, h = Π_l c_l(d_l)².

Every entry of the mass matrix may depend on every joint. With w = Λ qd', b = Λ qdd', v = qd,
a = qdd, subscripts of h its derivatives in d, and along qd and qd'

    h_v = Σ_l h_l v_l,   h_u = Σ_l h_l qd'_l,   h_vu = Σ_lm h_lm v_l qd'_m,

the push-forward (22) of the kernel is

    δ_nm Λ_n Σ_k (b_k (h a_k + h_v v_k) − w_k (h_u a_k + h_vu v_k))
    + Λ_m (b_n (h a_m + h_v v_m) − w_n (h_u a_m + h_vu v_m))
    − Λ_m v_m (h_n b·v − Σ_l h_nl qd'_l w·v) + w_n (h_m w·a + Σ_l h_ml v_l w·v)
    − ½ h_nm (w·v)².
"""

from numba import njit

from lagrangian_ff.kernels.structured.options import INNER, LANES


@njit(**INNER)
def kinetic(v, a, vu, au, c, inertia, link, work, square, out):  # type: ignore[no-untyped-def]
    """Write the blocks of one state with L others to out (N, N, L).

    Args:
        v, a: (N,) velocity and acceleration on the left.  vu, au: (N, L) and on the right.
        c: (3, N, L) factors and their derivatives.
        inertia: (N,) Λ.  link: (N,), of which the last scales all.
        work: (W, N, L), square: (S, N, N, L), to work in.
    """
    joints = v.shape[0]
    w, b, first, along_v, along_u = work[0], work[1], work[2], work[3], work[4]
    head, total = work[5], work[6]
    bend = square[0]
    scale = link[joints - 1]
    # total: h, h_v, h_u, h_vu, w·a, w·v, b·a, b·v in the rows of a few arrays.
    h, hv, hu, hvu = total[0], work[7][0], work[8][0], work[9][0]
    wa, wv, ba, bv = work[10][0], work[11][0], work[12][0], work[13][0]
    for z in range(LANES):
        h[z] = scale
        hv[z] = hu[z] = hvu[z] = wa[z] = wv[z] = ba[z] = bv[z] = 0.0
    for n in range(joints):
        for z in range(LANES):
            w[n, z] = inertia[n] * vu[n, z]
            b[n, z] = inertia[n] * au[n, z]
            wa[z] += w[n, z] * a[n]
            wv[z] += w[n, z] * v[n]
            ba[z] += b[n, z] * a[n]
            bv[z] += b[n, z] * v[n]
            # The product of all factors but the n-th, from both ends.
            head[n, z] = h[z]
            h[z] *= c[0, n, z] * c[0, n, z]
    tail = work[14]
    for z in range(LANES):
        tail[joints - 1, z] = 1.0
    for n in range(joints - 2, -1, -1):
        for z in range(LANES):
            tail[n, z] = tail[n + 1, z] * c[0, n + 1, z] * c[0, n + 1, z]
    for n in range(joints):
        for z in range(LANES):
            rise = 2.0 * c[0, n, z] * c[1, n, z]
            curve = 2.0 * (c[1, n, z] * c[1, n, z] + c[0, n, z] * c[2, n, z])
            first[n, z] = head[n, z] * rise * tail[n, z]
            bend[n, n, z] = head[n, z] * curve * tail[n, z]
            along_v[n, z] = 0.0
            along_u[n, z] = 0.0
            hv[z] += first[n, z] * v[n]
            hu[z] += first[n, z] * vu[n, z]
            work[15][0, z] = head[n, z] * rise
        for m in range(n + 1, joints):
            for z in range(LANES):
                rise = 2.0 * c[0, m, z] * c[1, m, z]
                bend[n, m, z] = work[15][0, z] * rise * tail[m, z]
                bend[m, n, z] = bend[n, m, z]
                work[15][0, z] *= c[0, m, z] * c[0, m, z]
    for n in range(joints):
        for m in range(joints):
            for z in range(LANES):
                along_v[n, z] += bend[n, m, z] * v[m]
                along_u[n, z] += bend[n, m, z] * vu[m, z]
        for z in range(LANES):
            hvu[z] += along_v[n, z] * vu[n, z]
    for n in range(joints):
        for m in range(joints):
            for z in range(LANES):
                straight = h[z] * a[m] + hv[z] * v[m]
                turned = hu[z] * a[m] + hvu[z] * v[m]
                out[n, m, z] = (
                    inertia[m]
                    * (
                        b[n, z] * straight
                        - w[n, z] * turned
                        - v[m] * (first[n, z] * bv[z] - along_u[n, z] * wv[z])
                    )
                    + w[n, z] * (first[m, z] * wa[z] + along_v[m, z] * wv[z])
                    - 0.5 * bend[n, m, z] * wv[z] * wv[z]
                )
        for z in range(LANES):
            out[n, n, z] += inertia[n] * (
                h[z] * ba[z] + hv[z] * bv[z] - hu[z] * wa[z] - hvu[z] * wv[z]
            )
