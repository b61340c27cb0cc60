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

SHORT, LONG = 3, 5
"""Functions of a joint of first and of second degree."""
MOST_JOINTS = 7
"""With more, the polynomial has more coefficients than it is worth: five times for each joint."""
CHUNK_STATES = 128
TURN = np.array(
    [[0, 0, 0, 0, 0], [0, 0, -1, 0, 0], [0, 1, 0, 0, 0], [0, 0, 0, 0, -2], [0, 0, 0, 2, 0]]
)
"""What makes of the functions of a joint, 1, cos, sin, cos 2, sin 2, their derivatives."""
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
    sums = [np.zeros((1 + joints, *size)) for size in _sizes(joints)]
    whole = np.zeros((joints, SHORT**joints))
    for first in range(0, len(u), CHUNK_STATES):
        part = slice(first, first + CHUNK_STATES)
        _add(u.take(part), np.ascontiguousarray(a[part].T), sums, whole)
    mass = [_slopes_taken(one, k, joints) for k, one in enumerate(sums)]
    potential = -np.sum([_turned(whole[n], SHORT, n) for n in range(joints)], axis=0)
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


def _add(u: States, a: Floats, sums: list[Floats], whole: Floats) -> None:
    """Add what the Euler-Lagrange operator makes of every product of functions, at u along a.

    The derivative of a product by a joint is again a sum of such products: here they are summed
    over the states as they are, once for each joint that they are to be derived by.

    Args:
        u: (M, N) states.  a: (N, M) coefficients.
        sums: for each k (1 + N, R_k, C_k), first what is taken as it is.
        whole: (N, 3^N) of the potential.
    """
    joints = u.joints
    qd, qdd = (np.ascontiguousarray(values.T) for values in (u.qd, u.qdd))
    functions = [_functions(u.q[:, n]) for n in range(joints)]
    one = np.ones((1, len(u)))
    tails = [one]
    for n in range(joints - 1, 0, -1):
        tails.insert(0, _times(functions[n], tails[0]))
    columns: list[Floats] = []
    for k in range(joints):
        short = functions[k][:SHORT]
        columns = [*(_times(middle, short) for middle in columns), one]
        row = 0
        for j, middle in enumerate(columns):
            turned = a[j] * qd[k] + a[k] * qd[j]
            weights = np.vstack([a[j] * qdd[k] + a[k] * qdd[j], turned * qd - qd[j] * qd[k] * a])
            rows = slice(row, row + len(middle))
            added = _times(weights, middle) @ tails[k].T
            sums[k][:, rows] += added.reshape(1 + joints, len(middle), -1)
            row = rows.stop
    product = one
    for n in range(joints):
        product = _times(product, functions[n][:SHORT])
    whole += a @ product.T


def _functions(q: Floats) -> Floats:
    """(F, M) functions of a joint."""
    return np.stack([np.ones_like(q), np.cos(q), np.sin(q), np.cos(2.0 * q), np.sin(2.0 * q)])


def _times(left: Floats, right: Floats) -> Floats:
    """(F G, M) products of functions."""
    return np.asarray((left[:, None] * right).reshape(-1, right.shape[-1]))


def _slopes_taken(sums: Floats, k: int, joints: int) -> Floats:
    """(R_k, C_k) the sums (1 + N, R_k, C_k), each derived by its joint."""
    out = sums[0].copy()
    row = 0
    for j in range(k + 1):
        rows = slice(row, row + SHORT ** (k - j))
        for n in range(j + 1, joints):
            of = sums[1 + n, rows]
            if n <= k:
                out[rows] += _turned(of, SHORT, n - j - 1)
            else:
                out[rows] += _turned(of.T, LONG, n - k - 1).T
        row = rows.stop
    return out


def _turned(sums: Floats, count: int, place: int) -> Floats:
    """The sums (F, ...) of products, of so many functions a joint, derived by the joint at a place.

    The first joint of the products changes slowest.
    """
    apart = sums.reshape(count**place, count, -1)
    return np.asarray((TURN[:count, :count] @ apart).reshape(sums.shape))


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
