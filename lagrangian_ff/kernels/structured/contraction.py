"""What pieces of a structured kernel do to weights and to a vector, no matrix written down."""

import numpy as np
from numba import njit

from lagrangian_ff.kernels.options import APART, APART_INNER, LANES
from lagrangian_ff.kernels.structured.factors import move, rate, swap
from lagrangian_ff.kernels.structured.lanes import kinetic, load, room
from lagrangian_ff.kernels.structured.potential import add_potential

KINETIC, POTENTIAL, ROTOR = 0, 1, 2
"""Of which part a piece is, and where its factors stand; a rotor's is qdd qdd' of one joint."""
STAYS = -1
"""Instead of the joint whose factor is moved, where none is."""


@njit(**APART_INNER)
def _load_weights(i, first, count, weights, vector, weighed, right):  # type: ignore[no-untyped-def]
    """Fetch the weights of a state's pairs to (N, N, L), the vector's part to right (N, L).

    A pair counts for its mirror image too; where a state meets itself, what stands above the
    diagonal counts with what stands below. Lanes beyond the count weigh nothing.
    """
    joints = right.shape[0]
    weighed[:, :, :] = 0.0
    right[:, :] = 0.0
    for z in range(count):
        j = first + z
        for n in range(joints):
            right[n, z] = vector[j, n]
            for m in range(joints if j < i else n):
                weighed[n, m, z] = 2.0 * weights[i * joints + n, j * joints + m]
            if j == i:
                weighed[n, n, z] = weights[i * joints + n, i * joints + n]


@njit(**APART_INNER)
def _load_moved(x, i, numbers, held, slope, factors, squares):  # type: ignore[no-untyped-def]
    """Write what the factors held become by a step along their derivative by ω; (2, N, 3, L).

    A step of 1 + ω: lost beside the factor for neither a small nor a large ω.
    """
    form, wave, swing = numbers[1], numbers[5], numbers[6]
    for n in range(form.shape[0]):
        for part in range(2):
            omega = wave[n] if part == KINETIC else swing[n]
            c, e = held[2][part, n], held[3][part, n]
            rate(form[n], omega, x, i, x, held[4], n, c, slope)
            move(1.0 + omega, slope, c, e, factors[part, n], squares[part, n])


@njit(inline="always", **APART_INNER)  # else all that it calls is compiled once more
def _write(kind, first, stop, inertia, share, serially, held, block):  # type: ignore[no-untyped-def]
    """Write the block of a piece, of its own joints only."""
    single, many, factors, squares, _, work = held
    a, au = single[1, first:stop], many[1, first:stop]
    if kind == KINETIC:
        v, vu = single[0, first:stop], many[0, first:stop]
        c, e = factors[0, first:stop], squares[0, first:stop]
        kinetic(serially, v, a, vu, au, c, e, inertia[first:stop], share[first:stop], work, block)
        return
    block[:, :, :] = 0.0
    if kind == POTENTIAL:
        g = factors[1, first:stop]
        add_potential(g, share[first:stop], work[0, 0], work[1, 0], work[2], block)
    else:
        for z in range(LANES):
            block[0, 0, z] = a[0] * au[0, z]


@njit(**APART_INNER)
def _contract(block, first, weights, left, right, total, rows, columns):  # type: ignore[no-untyped-def]
    """Write Σ_nm W_nm K_nm to total (L,), K a to rows (N, L), Kᵀ a to columns (N, L).

    Args:
        block: (J, J, L) K, of the joints from the first on.
        weights: (N, N, L) W.  left: (N,) a of the state on the left.
        right: (N, L) a of those on the right.
    """
    joints, _, lanes = block.shape
    total[:] = 0.0
    columns[:, :] = 0.0
    for n in range(joints):
        rows[n, :] = 0.0
        for m in range(joints):
            for z in range(lanes):
                entry = block[n, m, z]
                total[z] += weights[first + n, first + m, z] * entry
                rows[n, z] += entry * right[first + m, z]
                columns[m, z] += entry * left[first + n]


@njit(**APART)
def contract(x, rows, numbers, pieces, weights, vector, totals, products):  # type: ignore[no-untyped-def]
    """Add Σ_ab W_ab K_ab and K a of every piece K to totals (E,) and products (E, N, M).

    Of the pairs of some rows with themselves and the states before them, and their mirror images.

    Args:
        x: states as `compiled.prepared` gives them.
        rows: the first one, and how far on is the next.
        numbers: see `lanes.write_blocks`; the forms and ω are read.
        pieces: (E, 4) kind, first joint, the one after the last, the one whose factor is moved
            or STAYS; (E, N) Λ; (E, N) κ or λ.
        weights: (M N, M N) symmetric W, of which the lower triangle is read.
        vector: (M, N) a.
    """
    whats, inertias, shares = pieces
    samples, joints = vector.shape
    held = room(joints)
    _, _, factors, squares, _, _ = held
    moved, moved_squares = np.empty_like(factors), np.empty_like(squares)
    slope = np.empty((3, LANES))
    space, total = np.empty(joints * joints * LANES), np.empty(LANES)
    weighed, right = np.empty((joints, joints, LANES)), np.empty((joints, LANES))
    by_row, by_column = np.empty((joints, LANES)), np.empty((joints, LANES))
    for i in range(rows[0], samples, rows[1]):
        for first in range(0, i + 1, LANES):
            count = min(LANES, i + 1 - first)
            load(x, i, x, first, count, numbers, held)
            _load_moved(x, i, numbers, held, slope, moved, moved_squares)
            _load_weights(i, first, count, weights, vector, weighed, right)
            for p in range(whats.shape[0]):
                kind, begin, end, joint = whats[p, 0], whats[p, 1], whats[p, 2], whats[p, 3]
                block = space[: (end - begin) ** 2 * LANES].reshape(end - begin, end - begin, LANES)
                if joint != STAYS:
                    swap(factors[kind, joint], moved[kind, joint])
                    swap(squares[kind, joint], moved_squares[kind, joint])
                _write(kind, begin, end, inertias[p], shares[p], numbers[0], held, block)
                if joint != STAYS:
                    swap(factors[kind, joint], moved[kind, joint])
                    swap(squares[kind, joint], moved_squares[kind, joint])
                _contract(block, begin, weighed, vector[i], right, total, by_row, by_column)
                for z in range(LANES):
                    totals[p] += total[z]
                for n in range(end - begin):
                    for z in range(LANES):
                        products[p, begin + n, i] += by_row[n, z]
                    # A state paired with itself has no mirror image.
                    for z in range(min(count, i - first)):
                        products[p, begin + n, first + z] += by_column[n, z]
