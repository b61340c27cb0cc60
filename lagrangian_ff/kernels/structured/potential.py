"""The potential part of a Lagrangian kernel: Σ_i λ_i Π_{l≤i} g_l(d_l) over the links i.

The height of link i's centre of mass depends on the joints up to i. Its push-forward (22) is minus
the matrix of second derivatives in d.
"""

from numba import njit

from lagrangian_ff.kernels.options import APART_INNER


@njit(**APART_INNER)
def add_potential(g, weight, head, rise, tail, out):  # type: ignore[no-untyped-def]
    """Add the blocks to out (N, N, L).

    Args:
        g: (N, 3, L) factors and their derivatives.  weight: (N,) λ.
        head, rise: (L,), tail: (N or more, L), to work in.
    """
    joints, _, lanes = g.shape
    last = joints - 1
    for z in range(lanes):
        tail[last, z] = weight[last]
        head[z] = 1.0
    for n in range(last, 0, -1):
        for z in range(lanes):
            tail[n - 1, z] = weight[n - 1] + g[n, 0, z] * tail[n, z]
    for n in range(joints):
        for z in range(lanes):
            out[n, n, z] -= head[z] * g[n, 2, z] * tail[n, z]
            rise[z] = head[z] * g[n, 1, z]
            head[z] *= g[n, 0, z]
        for m in range(n + 1, joints):
            for z in range(lanes):
                both = rise[z] * g[m, 1, z] * tail[m, z]
                rise[z] *= g[m, 0, z]
                out[n, m, z] -= both
                out[m, n, z] -= both


@njit(**APART_INNER)
def slope_along(g, weight, a, product, rate, out):  # type: ignore[no-untyped-def]
    """Write the derivative of Σ_i λ_i Π_{l≤i} g_l(d_l) along a, as d moves, to out (L,).

    Args:
        g: (N, 3, L) factors and their derivatives.  weight: (N,) λ.  a: (N, L).
        product, rate: (L,) each, to work in.
    """
    joints, lanes = a.shape
    for z in range(lanes):
        product[z] = 1.0
        rate[z] = 0.0
        out[z] = 0.0
    for n in range(joints):
        for z in range(lanes):
            rate[z] = rate[z] * g[n, 0, z] + product[z] * g[n, 1, z] * a[n, z]
            product[z] *= g[n, 0, z]
            out[z] += weight[n] * rate[z]
