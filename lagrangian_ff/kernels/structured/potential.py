"""The potential part of a Lagrangian kernel: Σ_i λ_i Π_{l≤i} g_l(d_l) over the links i.

The height of link i's centre of mass depends on the joints up to i. Its push-forward (22) is minus
the matrix of second derivatives in d.
"""

from numba import njit

from lagrangian_ff.kernels.structured.options import INNER, LANES


@njit(**INNER)
def add_potential(g, weight, tail, head, out):  # type: ignore[no-untyped-def]
    """Add the blocks to out (N, N, L).

    Args:
        g: (3, N, L) factors and their derivatives.  weight: (N,) λ.
        tail, head: (N, L) each, to work in.
    """
    joints = weight.shape[0]
    last = joints - 1
    for z in range(LANES):
        tail[last, z] = weight[last]
        head[0, z] = 1.0
    for n in range(last - 1, -1, -1):
        for z in range(LANES):
            tail[n, z] = weight[n] + g[0, n + 1, z] * tail[n + 1, z]
    for n in range(joints):
        for z in range(LANES):
            out[n, n, z] -= head[0, z] * g[2, n, z] * tail[n, z]
            head[1, z] = head[0, z] * g[1, n, z]
            head[0, z] *= g[0, n, z]
        for m in range(n + 1, joints):
            for z in range(LANES):
                both = head[1, z] * g[1, m, z] * tail[m, z]
                head[1, z] *= g[0, m, z]
                out[n, m, z] -= both
                out[m, n, z] -= both


@njit(**INNER)
def slope_along(g, weight, a, product, rate, out):  # type: ignore[no-untyped-def]
    """Write the derivative of Σ_i λ_i Π_{l≤i} g_l(d_l) along a, as d moves, to out (L,).

    Args:
        g: (3, N, L) factors and their derivatives.  weight: (N,) λ.  a: (N, L).
        product, rate: (L,) each, to work in.
    """
    for z in range(LANES):
        product[z] = 1.0
        rate[z] = 0.0
        out[z] = 0.0
    for n in range(weight.shape[0]):
        for z in range(LANES):
            rate[z] = rate[z] * g[0, n, z] + product[z] * g[1, n, z] * a[n, z]
            product[z] *= g[0, n, z]
            out[z] += weight[n] * rate[z]
