"""Blocks of a structured kernel, some pairs of states side by side.

One compiled function serves for all that is made of blocks: compiling takes longer than using it.
"""

import numpy as np
from numba import njit

from lagrangian_ff.kernels.structured import product, serial
from lagrangian_ff.kernels.structured.factors import factor, move
from lagrangian_ff.kernels.structured.options import INNER, LANES, OPTIONS
from lagrangian_ff.kernels.structured.potential import add_potential, slope_along

ALL, LOWER, DIAGONAL = 0, 1, 2
"""Which pairs: each with each, each with those up to itself, or each with itself."""
NOTHING, WAVE, SWING = 0, 1, 2
"""Whose factors are moved: none, those of the kinetic part, those of the potential part."""


@njit(**INNER)
def _load(x, i, u, first, count, numbers, nudge, space):  # type: ignore[no-untyped-def]
    """Fetch state i, the states from `first` on, and the factors between them.

    Lanes beyond the count repeat the last one, so that every loop over them has one length.
    """
    form, wave, swing = numbers[1], numbers[5], numbers[6]
    what, joint, amount = nudge
    many, _, factors, single, lanes, rate = space
    for z in range(LANES):
        lanes[z] = first + min(z, count - 1)
    for n in range(form.shape[0]):
        single[0, n] = x[1][i, n]
        single[1, n] = x[2][i, n]
        for z in range(LANES):
            many[0, n, z] = u[1][lanes[z], n]
            many[1, n, z] = u[2][lanes[z], n]
        factor(form[n], wave[n], x, i, u, lanes, n, factors[0])
        factor(form[n], swing[n], x, i, u, lanes, n, factors[1])
    if what == WAVE:
        move(form[joint], wave[joint], amount, x, i, u, lanes, joint, factors[0], rate)
    elif what == SWING:
        move(form[joint], swing[joint], amount, x, i, u, lanes, joint, factors[1], rate)


@njit(**INNER)
def _blocks(numbers, parts, space, out):  # type: ignore[no-untyped-def]
    """Write the blocks of what was loaded to out (N, N, L)."""
    serially, _, inertia, link, potential, _, _, rotor = numbers
    many, square, factors, single, _, _ = space
    v, a, vu, au, work = single[0], single[1], many[0], many[1], many[4:]
    if not parts[0]:
        out[:, :, :] = 0.0
    elif serially:
        serial.kinetic(v, a, vu, au, factors[0], inertia, link, work, square, out)
    else:
        product.kinetic(v, a, vu, au, factors[0], inertia, link, work, square, out)
    if parts[1]:
        add_potential(factors[1], potential, many[2], many[3], out)
    for n in range(inertia.shape[0]):
        own = rotor[n] * inertia[n] * inertia[n] * a[n]
        for z in range(LANES):
            out[n, n, z] += own * au[n, z]


@njit(**OPTIONS)
def write_blocks(x, u, rows, base, pairs, numbers, parts, nudge, out):  # type: ignore[no-untyped-def]
    """Write K(x_i, u_j)_nm to out[i − base, n, j, m]; the diagonal to out[i − base, n, 0, m].

    Args:
        x, u: states as `compiled.prepared` gives them.
        rows: which i: from the first up to the second.
        pairs: ALL, LOWER or DIAGONAL.
        numbers: whether serial; (N,) each: form, inertia, link, potential, wave, swing, rotor.
        parts: whether there are a kinetic and a potential part.
        nudge: whose factor is moved along its slope in ω, NOTHING, WAVE or SWING; the joint; how
            far.
        out: (I, N, J, N).
    """
    joints = out.shape[1]
    space = (
        np.empty((20, max(joints, 2), LANES)),
        np.empty((8, joints, joints, LANES)),
        np.empty((2, 3, joints, LANES)),
        np.empty((2, joints)),
        np.empty(LANES, np.int64),
        np.empty((3, LANES)),
    )
    block = np.empty((joints, joints, LANES))
    for i in range(rows[0], rows[1]):
        begin = i if pairs == DIAGONAL else 0
        end = u[0].shape[0] if pairs == ALL else i + 1
        for first in range(begin, end, LANES):
            count = min(LANES, end - first)
            _load(x, i, u, first, count, numbers, nudge, space)
            _blocks(numbers, parts, space, block)
            for n in range(joints):
                for z in range(count):
                    for m in range(joints):
                        out[i - base, n, first - begin + z, m] = block[n, m, z]


@njit(**OPTIONS)
def write_potential(x, u, numbers, a, out):  # type: ignore[no-untyped-def]
    """Write Σ_j Σ_m T_m,u of the potential part (x_i, u_j) a_jm to out[i]: it is ∂/∂d there.

    Args:
        x, u: states as `compiled.prepared` gives them.
        numbers: see `write_blocks`.
        a: (J, N).  out: (I,).
    """
    form, potential, swing = numbers[1], numbers[4], numbers[6]
    joints, count = a.shape[1], a.shape[0]
    factors = np.empty((3, joints, LANES))
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
                factor(form[n], swing[n], x, i, u, lanes, n, factors)
                for z in range(LANES):
                    along[n, z] = a[lanes[z], n]
            slope_along(factors, potential, along, work[0], work[1], work[2])
            for z in range(here):
                out[i] += work[2, z]
