"""The compiled loops of `tree`: the regressor, sample by sample."""

import numpy as np
from numba import njit

from lagrangian_ff.kernels.options import INNER, OPTIONS


@njit(**OPTIONS)
def write_regressor(x, tree, gravity, out):  # type: ignore[no-untyped-def]
    """Add the torque of each joint per unit of each body's parameters to out (M, N, B, 10).

    Args:
        x: q, qd, qdd, (M, N) each.
        tree: parent, rotation, offset, axis, sliding, driver, ratio, shift; see `Tree`.
        gravity: (3,).
    """
    parent, _, _, axis, sliding, driver, ratio, _ = tree
    bodies = parent.shape[0]
    turn, place = np.empty((bodies, 3, 3)), np.empty((bodies, 3))
    motion = np.empty((bodies, 3, 3))
    wrench, moved = np.empty((2, 3, 10)), np.empty((2, 3, 10))
    for m in range(x[0].shape[0]):
        for body in range(bodies):
            _frame(x, m, tree, gravity, body, turn, place, motion)
        for body in range(bodies):
            _write_wrench(motion[body], wrench)
            at = body
            while at >= 0:
                joint = driver[at]
                if joint >= 0:
                    along = wrench[0] if sliding[at] > 0.0 else wrench[1]
                    for p in range(10):
                        for k in range(3):
                            out[m, joint, body, p] += ratio[at] * axis[at, k] * along[k, p]
                _to_parent(turn[at], place[at], wrench, moved)
                at = parent[at]


@njit(**INNER)
def _cross(a, b, k):  # type: ignore[no-untyped-def]
    """Component k of a × b."""
    i, j = (k + 1) % 3, (k + 2) % 3
    return a[i] * b[j] - a[j] * b[i]


@njit(**INNER)
def _frame(x, m, tree, gravity, body, turn, place, motion):  # type: ignore[no-untyped-def]
    """Where a body is in its parent, and ω, ω̇ and a of its frame, in its own coordinates."""
    parent, rotation, offset, axis, sliding, driver, ratio, shift = tree
    position, rate, change = shift[body], 0.0, 0.0
    joint = driver[body]
    if joint >= 0:
        position += ratio[body] * x[0][m, joint]
        rate, change = ratio[body] * x[1][m, joint], ratio[body] * x[2][m, joint]
    slides = sliding[body] > 0.0
    own = axis[body]
    sine, cosine = (0.0, 1.0) if slides else (np.sin(position), np.cos(position))
    for i in range(3):
        place[body, i] = offset[body, i]
        for j in range(3):
            # Rodrigues' formula, column by column.
            total = 0.0
            for k in range(3):
                about = (1.0 - cosine) * own[k] * own[j]
                if k == j:
                    about += cosine
                elif (k + 1) % 3 == j:
                    about -= sine * own[(k + 2) % 3]
                else:
                    about += sine * own[(k + 1) % 3]
                total += rotation[body, i, k] * about
            turn[body, i, j] = total
            if slides:
                place[body, i] += position * rotation[body, i, j] * own[j]
    omega, alpha, push = np.zeros(3), np.zeros(3), -gravity
    at = parent[body]
    if at >= 0:
        omega, alpha, push = motion[at, 0].copy(), motion[at, 1].copy(), motion[at, 2].copy()
        swing = np.empty(3)
        for k in range(3):
            swing[k] = _cross(omega, place[body], k)
        for k in range(3):
            push[k] += _cross(alpha, place[body], k) + _cross(omega, swing, k)
    for j in range(3):
        for which in range(3):
            motion[body, which, j] = 0.0
        for i in range(3):
            motion[body, 0, j] += turn[body, i, j] * omega[i]
            motion[body, 1, j] += turn[body, i, j] * alpha[i]
            motion[body, 2, j] += turn[body, i, j] * push[i]
    carried = motion[body, 0].copy()
    for k in range(3):
        across = rate * _cross(carried, own, k)
        if slides:
            motion[body, 2, k] += change * own[k] + 2.0 * across
        else:
            motion[body, 1, k] += change * own[k] + across
            motion[body, 0, k] += rate * own[k]


@njit(**INNER)
def _write_wrench(motion, wrench):  # type: ignore[no-untyped-def]
    """Write force and moment per unit of a body's parameters to wrench (2, 3, 10)."""
    omega, alpha, push = motion[0], motion[1], motion[2]
    wrench[:, :, :] = 0.0
    square = omega[0] ** 2 + omega[1] ** 2 + omega[2] ** 2
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        wrench[0, i, 0] = push[i]
        for n in range(3):
            wrench[0, i, 1 + n] += omega[i] * omega[n]
        wrench[0, i, 1 + i] -= square
        wrench[0, i, 1 + j] -= alpha[k]
        wrench[0, i, 1 + k] += alpha[j]
        wrench[1, i, 1 + j] += push[k]
        wrench[1, i, 1 + k] -= push[j]
    # I v for I = (Ixx, Ixy, Iyy, Ixz, Iyz, Izz): which entry of it stands in row i, column n.
    for i in range(3):
        for n in range(3):
            low, high = min(i, n), max(i, n)
            entry = 4 + high * (high + 1) // 2 + low
            wrench[1, i, entry] += alpha[n]
            # ω × (I ω): row i of I ω adds to the two other rows.
            wrench[1, (i + 1) % 3, entry] += omega[(i + 2) % 3] * omega[n]
            wrench[1, (i + 2) % 3, entry] -= omega[(i + 1) % 3] * omega[n]


@njit(**INNER)
def _to_parent(turn, place, wrench, moved):  # type: ignore[no-untyped-def]
    """Rotate and move a wrench into the frame of the parent, in place."""
    for p in range(10):
        for which in range(2):
            for i in range(3):
                total = 0.0
                for j in range(3):
                    total += turn[i, j] * wrench[which, j, p]
                moved[which, i, p] = total
        for i in range(3):
            j, k = (i + 1) % 3, (i + 2) % 3
            moved[1, i, p] += place[j] * moved[0, k, p] - place[k] * moved[0, j, p]
    # A loop: assigning to a slice takes seconds to compile, for its error message.
    for which in range(2):
        for i in range(3):
            for p in range(10):
                wrench[which, i, p] = moved[which, i, p]
