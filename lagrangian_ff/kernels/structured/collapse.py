"""From the states a chain was learned from, and their weights, to its polynomial (polynomial.c)."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lagrangian_ff.kernels import threads
from lagrangian_ff.kernels.base import Learned
from lagrangian_ff.kernels.states import States, contiguous
from lagrangian_ff.kernels.structured.base import Structured
from lagrangian_ff.loops import loop

Floats = NDArray[np.float64]
Three = tuple[Floats, Floats, Floats]

SHORT, LONG = 3, 5
"""Functions of a joint of first and of second degree."""
MOST_JOINTS = 7
"""With more, the polynomial has more coefficients than it is worth: five times for each joint."""
CHUNK_STATES = 128
COEFFICIENTS_A_BLOCK = 400
"""Coefficients that cost as much at a state as a pair that `threads` counts."""


@dataclass(frozen=True)
class Polynomial(Learned):
    """A learned chain, of no more to compute however many states it was learned from.

    Attributes:
        mass, potential, rotor: the B_k one after the other, row by row; (3^N,); (N,).
    """

    mass: Floats
    potential: Floats
    rotor: Floats

    def torque(self, x: States) -> Floats:
        """See `Learned.torque`."""
        out = np.empty(x.q.shape)
        states = contiguous(x)

        def write(rows: slice) -> None:
            part, to = (values[rows] for values in states), out[rows]
            numbers = self.mass, self.potential, self.rotor
            loop("polynomial_torques")(x.joints, *part, len(to), *numbers, to)

        threads.over_rows(write, len(x), len(x) * self.mass.size / COEFFICIENTS_A_BLOCK)
        return out


def collapsed(kernel: Structured, u: States, a: Floats) -> Polynomial:
    """The polynomial Σ_j K(·, u_j) a_j of a chain with cosine factors.

    Args:
        kernel: the chain.
        u: (M, N) states.  a: (M, N) coefficients.
    """
    joints = u.joints
    mass = [np.zeros(size) for size in _sizes(joints)]
    potential = np.zeros(SHORT**joints)
    for first in range(0, len(u), CHUNK_STATES):
        part = slice(first, first + CHUNK_STATES)
        _add(u.take(part), a[part], mass, potential)
    for k, (block, (rows, columns)) in enumerate(
        zip(mass, zip(_row_weights(kernel), _tail_weights(kernel), strict=True), strict=True)
    ):
        block *= np.outer(rows, columns) * kernel.inertia[k]
    rotor = kernel.rotor * kernel.inertia**2 * np.sum(u.qdd * a, axis=0)
    flat = np.concatenate([block.ravel() for block in mass])
    return Polynomial(flat, potential * _potential_weights(kernel), rotor)


def _sizes(joints: int) -> list[tuple[int, int]]:
    """Rows and columns of the coefficients for each k."""
    return [((SHORT ** (k + 1) - 1) // 2, LONG ** (joints - 1 - k)) for k in range(joints)]


def _add(u: States, a: Floats, mass: list[Floats], potential: Floats) -> None:
    """Add what the Euler-Lagrange operator makes of every product of functions, at u along a."""
    joints = u.joints
    short = [_functions(u, a, n, SHORT) for n in range(joints)]
    long = [_functions(u, a, n, LONG) for n in range(joints)]
    one = _constant(len(u))
    tails = [one]
    for n in range(joints - 1, 0, -1):
        tails.insert(0, _times(long[n], tails[0]))
    columns: list[tuple[int, Three]] = []
    for k in range(joints):
        columns = [(j, _times(middle, short[k])) for j, middle in columns] + [(k, one)]
        tail, tail_v, tail_a = tails[k]
        row = 0
        for j, (middle, middle_v, middle_a) in columns:
            both = (a[:, j] * u.qdd[:, k] + a[:, k] * u.qdd[:, j])[:, None]
            turned = (a[:, j] * u.qd[:, k] + a[:, k] * u.qd[:, j])[:, None]
            square = -(u.qd[:, j] * u.qd[:, k])[:, None]
            here = mass[k][row : row + middle.shape[1]]
            here += (both * middle + turned * middle_v + square * middle_a).T @ tail
            here += (turned * middle).T @ tail_v + (square * middle).T @ tail_a
            row += middle.shape[1]
    whole = one
    for n in range(joints):
        whole = _times(whole, short[n])
    potential -= whole[2].sum(axis=0)


def _functions(u: States, a: Floats, joint: int, count: int) -> Three:
    """(M, F) functions of a joint, and their derivatives along velocity and along a."""
    q = u.q[:, joint]
    value = [np.ones_like(q), np.cos(q), np.sin(q), np.cos(2.0 * q), np.sin(2.0 * q)]
    slope = [np.zeros_like(q), -value[2], value[1], -2.0 * value[4], 2.0 * value[3]]
    columns, slopes = np.stack(value[:count], axis=1), np.stack(slope[:count], axis=1)
    return columns, slopes * u.qd[:, [joint]], slopes * a[:, [joint]]


def _constant(count: int) -> Three:
    return np.ones((count, 1)), np.zeros((count, 1)), np.zeros((count, 1))


def _times(left: Three, right: Three) -> Three:
    """(M, F G) products of functions, and their derivatives."""

    def outer(one: Floats, other: Floats) -> Floats:
        return np.asarray((one[:, :, None] * other[:, None, :]).reshape(len(one), -1))

    value, value_v, value_a = left
    other, other_v, other_a = right
    return (
        outer(value, other),
        outer(value_v, other) + outer(value, other_v),
        outer(value_a, other) + outer(value, other_a),
    )


def _kron(left: Floats, right: Floats) -> Floats:
    return np.asarray(np.kron(left, right), dtype=np.float64)


def _short(omega: float) -> Floats:
    """Weights of 1, cos, sin in a factor (1 + ω cos d) / (1 + ω)."""
    return np.array([1.0, omega, omega]) / (1.0 + omega)


def _row_weights(kernel: Structured) -> list[Floats]:
    found: list[Floats] = []
    rows: Floats = np.zeros(0)
    for k, omega in enumerate(kernel.wave):
        rows = np.concatenate([_kron(rows, _short(omega)), [kernel.inertia[k]]])
        found.append(rows)
    return found


def _tail_weights(kernel: Structured) -> list[Floats]:
    joints = len(kernel.link)
    found: list[Floats] = [np.array([kernel.link[-1]])]
    for k in range(joints - 2, -1, -1):
        constant, wave, _ = _short(kernel.wave[k + 1])
        half = 0.5 * wave**2
        square = np.array([constant**2 + half, *[2.0 * constant * wave] * 2, half, half])
        found.insert(0, _kron(square, found[0]))
        found[0][0] += kernel.link[k]
    return found


def _potential_weights(kernel: Structured) -> Floats:
    head: Floats = np.ones(1)
    weights: Floats = np.zeros(1)
    constant: Floats = np.eye(SHORT)[0]
    for omega, height in zip(kernel.swing, kernel.potential, strict=True):
        head = _kron(head, _short(omega))
        weights = _kron(weights, constant)
        weights += height * head
    return weights
