"""Blocks of a structured kernel, some pairs of states side by side.

One compiled function serves for all that is made of blocks: compiling takes longer than using it.
"""

import numpy as np
from numba import njit

from lagrangian_ff.kernels.options import APART, APART_INNER, LANES
from lagrangian_ff.kernels.structured import product, serial
from lagrangian_ff.kernels.structured.factors import factor, square
from lagrangian_ff.kernels.structured.potential import add_potential, slope_along

ALL, LOWER, DIAGONAL = 0, 1, 2
"""Which pairs: each with each, each with those up to itself, or each with itself."""


@njit(**APART_INNER)
def room(joints):  # type: ignore[no-untyped-def]
    """What `load` fills, and what blocks are worked out in.

    Returns:
        (2, N) velocity and acceleration on the left, (2, N, L) and on the right, (2, N, 3, L)
        factors of the kinetic and of the potential part, (2, N, 3, L) their squares, (L,) the
        states on the right, (W, N, L) to work in.
    """
    return (
        np.empty((2, joints)),
        np.empty((2, joints, LANES)),
        np.empty((2, joints, 3, LANES)),
        np.empty((2, joints, 3, LANES)),
        np.empty(LANES, np.int64),
        np.empty((21 + joints, joints, LANES)),
    )


@njit(**APART_INNER)
def load(x, i, u, first, count, numbers, held):  # type: ignore[no-untyped-def]
    """Fetch state i, the states from `first` on, and the factors between them, to what is held.

    Lanes beyond the count repeat the last one, so that every loop over them has one length.
    """
    form, wave, swing = numbers[1], numbers[5], numbers[6]
    single, many, factors, squares, lanes, _ = held
    for z in range(LANES):
        lanes[z] = first + min(z, count - 1)
    for n in range(form.shape[0]):
        single[0, n] = x[1][i, n]
        single[1, n] = x[2][i, n]
        for z in range(LANES):
            many[0, n, z] = u[1][lanes[z], n]
            many[1, n, z] = u[2][lanes[z], n]
        factor(form[n], wave[n], x, i, u, lanes, n, factors[0, n])
        factor(form[n], swing[n], x, i, u, lanes, n, factors[1, n])
        for part in range(2):
            square(factors[part, n], squares[part, n])


@njit(inline="always", **APART_INNER)  # else all that it calls is compiled once more
def kinetic(serially, v, a, vu, au, c, e, inertia, link, work, out):  # type: ignore[no-untyped-def]
    """Write the blocks of the kinetic part to out (N, N, L); see `serial` and `product`."""
    if serially:
        serial.kinetic(v, a, vu, au, c, e, inertia, link, work, out)
    else:
        product.kinetic(v, a, vu, au, e, inertia, link, work, out)


@njit(**APART)
def write_blocks(x, u, rows, base, pairs, numbers, out):  # type: ignore[no-untyped-def]
    """Write K(x_i, u_j)_nm to out[i − base, n, j, m]; the diagonal to out[i − base, n, 0, m].

    Args:
        x, u: states as `compiled.prepared` gives them.
        rows: which i: from the first up to the second.
        pairs: ALL, LOWER or DIAGONAL.
        numbers: whether serial; (N,) each: form, inertia, link, potential, wave, swing, rotor.
        out: (I, N, J, N).
    """
    serially, _, inertia, link, potential, _, _, rotor = numbers
    joints = out.shape[1]
    held = room(joints)
    single, many, factors, squares, _, work = held
    v, a, vu, au = single[0], single[1], many[0], many[1]
    c, g, e = factors[0], factors[1], squares[0]
    block = np.empty((joints, joints, LANES))
    for i in range(rows[0], rows[1]):
        begin = i if pairs == DIAGONAL else 0
        end = u[0].shape[0] if pairs == ALL else i + 1
        for first in range(begin, end, LANES):
            count = min(LANES, end - first)
            load(x, i, u, first, count, numbers, held)
            kinetic(serially, v, a, vu, au, c, e, inertia, link, work, block)
            add_potential(g, potential, work[0, 0], work[1, 0], work[2], block)
            for n in range(joints):
                own = rotor[n] * inertia[n] * inertia[n] * a[n]
                for z in range(LANES):
                    block[n, n, z] += own * au[n, z]
            for n in range(joints):
                for z in range(count):
                    for m in range(joints):
                        out[i - base, n, first - begin + z, m] = block[n, m, z]


@njit(**APART)
def write_potential(x, u, numbers, a, out):  # type: ignore[no-untyped-def]
    """Write Σ_j Σ_m T_m,u of the potential part (x_i, u_j) a_jm to out[i]: it is ∂/∂d there.

    Args:
        x, u: states as `compiled.prepared` gives them.
        numbers: see `write_blocks`.
        a: (J, N).  out: (I,).
    """
    form, potential, swing = numbers[1], numbers[4], numbers[6]
    joints, count = a.shape[1], a.shape[0]
    factors = np.empty((joints, 3, LANES))
    along = np.empty((joints, LANES))
    work = np.empty((3, LANES))
    lanes = np.empty(LANES, np.int64)
    for i in range(x[0].shape[0]):
        out[i] = 0.0
        for first in range(0, count, LANES):
            here = min(LANES, count - first)
            for z in range(LANES):
                lanes[z] = first + min(z, here - 1)
            for n in range(joints):
                factor(form[n], swing[n], x, i, u, lanes, n, factors[n])
                for z in range(LANES):
                    along[n, z] = a[lanes[z], n]
            slope_along(factors, potential, along, work[0], work[1], work[2])
            for z in range(here):
                out[i] += work[2, z]
