"""The structured kernels of serial and of any arms, and the polynomial form of a learned chain."""

from dataclasses import dataclass

import numpy as np

from lagrangian_ff.arrays import Floats
from lagrangian_ff.kernels import threads
from lagrangian_ff.kernels.base import Learned
from lagrangian_ff.kernels.states import States, contiguous
from lagrangian_ff.kernels.structured.base import BELL, COSINE, Structured
from lagrangian_ff.loops import loop

SHORT, LONG = 3, 5
"""Numbers of functions of a joint of first and of second degree."""
MOST_JOINTS = 7
"""With more joints the polynomial is slower than the sum: each takes five times as long."""
CHUNK_STATES = 128
TURN = np.array(
    [[0, 0, 0, 0, 0], [0, 0, -1, 0, 0], [0, 1, 0, 0, 0], [0, 0, 0, 0, -2], [0, 0, 0, 2, 0]]
)
"""Derivatives of the functions of a joint, 1, cos, sin, cos 2, sin 2, by these functions."""
COEFFICIENTS_A_BLOCK = 400
"""Coefficients that cost as much at a state as one pair that `threads` counts."""


@dataclass(frozen=True)
class Polynomial(Learned):
    """A learned chain, at a cost that does not depend on the states it was learned from.

    Attributes:
        mass, potential, rotor: the B_k one after the other, row by row; (3^N,); (N,).
    """

    mass: Floats
    potential: Floats
    rotor: Floats

    def torque(self, x: States) -> Floats:
        out = np.empty(x.q.shape)
        states = contiguous(x)

        def write(rows: slice) -> None:
            part, to = (values[rows] for values in states), out[rows]
            numbers = self.mass, self.potential, self.rotor
            loop("polynomial_torques")(x.joints, *part, len(to), *numbers, to)

        threads.over_rows(write, len(x), len(x) * self.mass.size / COEFFICIENTS_A_BLOCK)
        return out


def polynomial_of(kernel: Structured, u: States, a: Floats) -> Polynomial:
    """Return the polynomial Σ_j K(·, u_j) a_j of a chain with cosine factors, u and a (M, N)."""
    joints = u.joints
    sums = [np.zeros((1 + joints, *size)) for size in _sizes(joints)]
    whole = np.zeros((joints, SHORT**joints))
    for first in range(0, len(u), CHUNK_STATES):
        part = slice(first, first + CHUNK_STATES)
        _add(u.take(part), np.ascontiguousarray(a[part].T), sums, whole)
    mass = [_derived(one, k, joints) for k, one in enumerate(sums)]
    potential = -np.sum([_derived_by(whole[n], SHORT, n) for n in range(joints)], axis=0)
    for k, (block, (rows, columns)) in enumerate(
        zip(mass, zip(_row_weights(kernel), _tail_weights(kernel), strict=True), strict=True)
    ):
        block *= np.outer(rows, columns) * kernel.inertia[k]
    rotor = kernel.rotor * kernel.inertia**2 * np.sum(u.qdd * a, axis=0)
    flat = np.concatenate([block.ravel() for block in mass])
    return Polynomial(flat, potential * _potential_weights(kernel), rotor)


def _sizes(joints: int) -> list[tuple[int, int]]:
    """Return the rows and columns of the coefficients for each k."""
    return [((SHORT ** (k + 1) - 1) // 2, LONG ** (joints - 1 - k)) for k in range(joints)]


def _add(u: States, a: Floats, sums: list[Floats], whole: Floats) -> None:
    """Add the Euler-Lagrange operator of every product of functions, at u along a.

    The derivative of a product by a joint is again a sum of such products: here they are summed
    over the states as they are, once for each joint that they are to be derived by.

    Args:
        u: (M, N) states.  a: (N, M) coefficients.
        sums: for each k (1 + N, R_k, C_k), the first not to be derived.
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
    """Return (F, M) the functions of a joint."""
    return np.stack([np.ones_like(q), np.cos(q), np.sin(q), np.cos(2.0 * q), np.sin(2.0 * q)])


def _times(left: Floats, right: Floats) -> Floats:
    """Return (F G, M) the products of functions."""
    return np.asarray((left[:, None] * right).reshape(-1, right.shape[-1]))


def _derived(sums: Floats, k: int, joints: int) -> Floats:
    """Return (R_k, C_k) the total of the sums (1 + N, R_k, C_k), each derived by its joint."""
    out = sums[0].copy()
    row = 0
    for j in range(k + 1):
        rows = slice(row, row + SHORT ** (k - j))
        for n in range(j + 1, joints):
            of = sums[1 + n, rows]
            if n <= k:
                out[rows] += _derived_by(of, SHORT, n - j - 1)
            else:
                out[rows] += _derived_by(of.T, LONG, n - k - 1).T
        row = rows.stop
    return out


def _derived_by(sums: Floats, count: int, place: int) -> Floats:
    """Return the sums (F, ...) of products of `count` functions a joint, derived by one joint.

    The first joint of the products changes slowest.
    """
    apart = sums.reshape(count**place, count, -1)
    return np.asarray((TURN[:count, :count] @ apart).reshape(sums.shape))


def _kron(left: Floats, right: Floats) -> Floats:
    return np.asarray(np.kron(left, right), dtype=np.float64)


def _short(omega: float) -> Floats:
    """Return the weights of 1, cos, sin in a factor (1 + ω cos d) / (1 + ω)."""
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


class Chain(Structured):
    """The rigid-body dynamics of serial arms, see `serial.c`.

    Cosine factors: inertia and gravity are the trigonometric polynomials that rigid bodies have.
    """

    name = "chain"
    meaning = "one Lagrangian of a serial arm: quadratic in velocity, gravity apart"
    form = COSINE
    serial = True

    def learned(self, u: States, a: Floats) -> Learned:
        if u.joints > MOST_JOINTS or self.prismatic.any():
            return super().learned(u, a)
        return polynomial_of(self, u, a)


class ChainRbf(Structured):
    """As `Chain`, with inertia and gravity any smooth functions of the angles they depend on."""

    name = "chain_rbf"
    meaning = "as chain, with rbf factors: gears and links need not be rigid bodies"
    form = BELL
    free = True
    serial = True


class Energy(Structured):
    """Kinetic energy quadratic in velocity and a potential, both of all joints; see `product.c`.

    Cosine factors: inertia and gravity are trigonometric polynomials in every joint.
    """

    name = "energy"
    meaning = "one Lagrangian of any arm: quadratic in velocity, gravity apart"
    form = COSINE
    serial = False


class EnergyRbf(Structured):
    """As `Energy`, with inertia and gravity any smooth functions of the joints."""

    name = "energy_rbf"
    meaning = "as energy, with rbf factors: inertia and gravity any smooth functions"
    form = BELL
    free = True
    serial = False
