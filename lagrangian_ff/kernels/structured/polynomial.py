"""A learned Lagrangian of rigid links as the trigonometric polynomial that it is.

With cosine factors, entry (j, k), j ≤ k, of the mass matrix is of first degree in cosine and sine
of the joints j+1 .. k and of second degree in those beyond (see `serial`), and the potential of
first degree in all. From however many states it was learned, its coefficients are as many:

    M_jk(q) = μ_jk(q)ᵀ B_jk τ_k(q),     μ_jk = ⊗_{j<l≤k} (1, cos, sin)(q_l),
                                        τ_k  = ⊗_{l>k} (1, cos, sin, cos 2, sin 2)(q_l).

The blocks B_jk of one k stand on each other, j = 0 first, as do the μ_jk: a row more for every k.
"""

import numpy as np
from numba import njit
from numpy.typing import NDArray

from lagrangian_ff.kernels.options import APART, APART_INNER

Floats = NDArray[np.float64]

SHORT, LONG = 3, 5
"""Functions of a joint of first and of second degree."""


def sizes(joints: int) -> list[tuple[int, int]]:
    """Rows and columns of the coefficients for each k."""
    return [((SHORT ** (k + 1) - 1) // 2, LONG ** (joints - 1 - k)) for k in range(joints)]


def workspace(joints: int) -> tuple[Floats, Floats, Floats, Floats]:
    """What `torques` works in: functions of each joint, of tails, of rows, of the potential."""
    rows, columns = (sum(size) for size in zip(*sizes(joints), strict=True))
    potential = (SHORT**joints - 1) // 2
    return (
        np.empty((6, joints, LONG)),
        np.empty((4, columns)),
        np.empty((5, rows)),
        np.empty((2, potential + SHORT**joints)),
    )


@njit(**APART_INNER)
def _functions(q, of_joint):  # type: ignore[no-untyped-def]
    """Write 1, cos q, sin q, cos 2q, sin 2q of every joint, and their slopes."""
    for n in range(q.shape[0]):
        cosine, sine = np.cos(q[n]), np.sin(q[n])
        double, twice = cosine * cosine - sine * sine, 2.0 * sine * cosine
        of_joint[0, n, 0], of_joint[0, n, 1], of_joint[0, n, 2] = 1.0, cosine, sine
        of_joint[0, n, 3], of_joint[0, n, 4] = double, twice
        of_joint[1, n, 0], of_joint[1, n, 1], of_joint[1, n, 2] = 0.0, -sine, cosine
        of_joint[1, n, 3], of_joint[1, n, 4] = -2.0 * twice, 2.0 * double


@njit(**APART_INNER)
def _tails(v, of_joint, tails):  # type: ignore[no-untyped-def]
    """Write τ_k, all k one after the other, k = 0 first, and how they change along v."""
    joints = v.shape[0]
    value, change = tails[0], tails[1]
    width, source = 1, value.shape[0] - 1
    value[source], change[source] = 1.0, 0.0
    for k in range(joints - 2, -1, -1):
        first = source - LONG * width
        for f in range(LONG):
            b, db = of_joint[0, k + 1, f], of_joint[1, k + 1, f] * v[k + 1]
            at = first + f * width
            old, rate = value[source : source + width], change[source : source + width]
            new, slope = value[at : at + width], change[at : at + width]
            for r in range(width):
                new[r] = b * old[r]
            for r in range(width):
                slope[r] = b * rate[r] + db * old[r]
        source, width = first, LONG * width


@njit(**APART_INNER)
def _rows(v, of_joint, rows):  # type: ignore[no-untyped-def]
    """Write μ_jk, all k one after the other, and how they change along v."""
    value, change = rows[0], rows[1]
    value[0], change[0] = 1.0, 0.0
    before, count = 0, 1
    for k in range(1, v.shape[0]):
        first = before + count
        for r in range(count):
            for f in range(SHORT):
                b, db = of_joint[0, k, f], of_joint[1, k, f] * v[k]
                value[first + SHORT * r + f] = b * value[before + r]
                change[first + SHORT * r + f] = b * change[before + r] + db * value[before + r]
        before, count = first, SHORT * count + 1
        value[before + count - 1], change[before + count - 1] = 1.0, 0.0


@njit(**APART_INNER)
def _momenta(v, a, mass, tails, rows, out):  # type: ignore[no-untyped-def]
    """Write M a + Ṁ v to out, and what ½ vᵀ M v gains with each μ and τ to rows[4] and tails[2]."""
    joints = v.shape[0]
    out[:] = 0.0
    tails[2, :] = 0.0
    entry, column, row, width = 0, 0, 0, LONG ** (joints - 1)
    for k in range(joints):
        value, slope = tails[0, column : column + width], tails[1, column : column + width]
        gained = tails[2, column : column + width]
        for j in range(k + 1):
            count = 1
            for _ in range(k - j):
                count *= SHORT
            share = v[j] * v[k] if j < k else 0.5 * v[k] * v[k]
            inertia, rate = 0.0, 0.0
            for _ in range(count):
                weight = share * rows[0, row]
                total, change = 0.0, 0.0
                coefficients = mass[entry : entry + width]
                for c in range(width):
                    total += coefficients[c] * value[c]
                    change += coefficients[c] * slope[c]
                for c in range(width):
                    gained[c] += weight * coefficients[c]
                inertia += rows[0, row] * total
                rate += rows[1, row] * total + rows[0, row] * change
                rows[4, row] = share * total
                entry += width
                row += 1
            out[j] += inertia * a[k] + rate * v[k]
            if j < k:
                out[k] += inertia * a[j] + rate * v[j]
        column += width
        width //= LONG


@njit(**APART_INNER)
def _subtract_slopes(of_joint, tails, rows, out):  # type: ignore[no-untyped-def]
    """Subtract from out how ½ vᵀ M v changes with each joint, by what it gains with μ and τ."""
    joints = out.shape[0]
    count = (SHORT**joints - 1) // 2
    first = rows.shape[1] - count
    for k in range(joints - 1, 0, -1):
        count = (count - 1) // SHORT
        before = first - count
        slope = 0.0
        for r in range(count):
            gained = 0.0
            for f in range(SHORT):
                one = rows[4, first + SHORT * r + f]
                gained += of_joint[0, k, f] * one
                slope += rows[0, before + r] * of_joint[1, k, f] * one
            rows[4, before + r] += gained
        out[k] -= slope
        first = before
    first, width = 0, LONG ** (joints - 1)
    for k in range(joints - 1):
        source = first + width
        width //= LONG
        slope = 0.0
        for f in range(LONG):
            b, db = of_joint[0, k + 1, f], of_joint[1, k + 1, f]
            at = first + f * width
            gained, below = tails[2, at : at + width], tails[2, source : source + width]
            value = tails[0, source : source + width]
            for r in range(width):
                below[r] += b * gained[r]
            part = 0.0
            for r in range(width):
                part += gained[r] * value[r]
            slope += db * part
        out[k + 1] -= slope
        first = source


@njit(**APART_INNER)
def _subtract_potential(potential, of_joint, work, out):  # type: ignore[no-untyped-def]
    """Subtract from out how the potential part of the Lagrangian changes with each joint."""
    joints = out.shape[0]
    head, tail = work[0], work[1]
    # Products of the first joints' functions, n = 0 first; what the last joints make of the rest.
    head[0] = 1.0
    first, width = 0, 1
    for n in range(joints - 1):
        for r in range(width):
            for f in range(SHORT):
                head[first + width + SHORT * r + f] = head[first + r] * of_joint[0, n, f]
        first, width = first + width, SHORT * width
    at = tail.shape[0] - potential.shape[0]
    # A loop: assigning to a slice takes seconds to compile, for its error message.
    for r in range(potential.shape[0]):
        tail[at + r] = potential[r]
    for n in range(joints - 1, -1, -1):
        below = at - width
        slope = 0.0
        for r in range(width):
            value, change = 0.0, 0.0
            for f in range(SHORT):
                one = tail[at + SHORT * r + f]
                value += of_joint[0, n, f] * one
                change += of_joint[1, n, f] * one
            tail[below + r] = value
            slope += head[first + r] * change
        out[n] -= slope
        at = below
        width //= SHORT
        first -= width


@njit(**APART)
def torques(q, qd, qdd, mass, potential, rotor, work, out):  # type: ignore[no-untyped-def]
    """Write the torques of states (M, N) to out (M, N).

    Args:
        mass: the B_k, one after the other, row by row.  potential: (3^N,).  rotor: (N,).
        work: see `workspace`.
    """
    of_joint, tails, rows, heads = work
    for i in range(q.shape[0]):
        _functions(q[i], of_joint)
        _tails(qd[i], of_joint, tails)
        _rows(qd[i], of_joint, rows)
        _momenta(qd[i], qdd[i], mass, tails, rows, out[i])
        _subtract_slopes(of_joint, tails, rows, out[i])
        _subtract_potential(potential, of_joint, heads, out[i])
        for n in range(q.shape[1]):
            out[i, n] += rotor[n] * qdd[i, n]
