"""The kernel of a serial chain, against symbolic differentiation and a real arm's equations."""

import numpy as np
import sympy
from test_kernel_list import random_states

from lagrangian_ff.kernels import States
from lagrangian_ff.kernels.prefixes import Prefixes

INERTIA, POTENTIAL, WAVE, ROTOR = (0.7, 0.4), 1.3, 0.6, 2.0


def kernel() -> Prefixes:
    return Prefixes(np.array(INERTIA), np.array([POTENTIAL]), np.array([WAVE]), np.array([ROTOR]))


def symbolic_block(x: States, u: States) -> np.ndarray:
    """K (2, 2) for one pair: the Euler-Lagrange operator applied twice to the definition."""
    first = [sympy.symbols(f"x{name}:2") for name in ("q", "qd", "qdd")]
    second = [sympy.symbols(f"u{name}:2") for name in ("q", "qd", "qdd")]
    total, rate, wave = sympy.Integer(0), sympy.Integer(0), sympy.Integer(1)
    for j in range(2):
        rate += INERTIA[j] * first[1][j] * second[1][j]
        difference = first[0][j] - second[0][j]
        wave *= ((1 + WAVE * sympy.cos(difference)) / (1 + WAVE)) ** 2
        total += (rate**2 / 2 + POTENTIAL) * wave
        total += ROTOR / 4 * (INERTIA[j] * first[1][j] * second[1][j]) ** 2

    def euler_lagrange(f: sympy.Expr, state: list[tuple[sympy.Symbol, ...]], n: int) -> sympy.Expr:
        q, qd, qdd = state
        momentum = sympy.diff(f, qd[n])
        change = sum(sympy.diff(momentum, q[k]) * qd[k] for k in range(2))
        change += sum(sympy.diff(momentum, qd[k]) * qdd[k] for k in range(2))
        return change - sympy.diff(f, q[n])

    rows = [euler_lagrange(total, second, m) for m in range(2)]
    block = [euler_lagrange(row, first, n) for n in range(2) for row in rows]
    symbols = [s for state in (first, second) for group in state for s in group]
    values = [float(v) for s in (x, u) for part in (s.q, s.qd, s.qdd) for v in part[0]]
    return np.reshape(sympy.lambdify(symbols, block, "numpy")(*values), (2, 2))


def test_it_is_its_definition_pushed_through_euler_lagrange_twice() -> None:
    for seed in range(4):
        x, u = random_states(1, 2, seed), random_states(1, 2, 100 + seed)
        np.testing.assert_allclose(kernel().cross(x, u), symbolic_block(x, u), atol=1e-12)


def test_it_holds_a_double_pendulum_exactly() -> None:
    """m l² (2 + 2 cos q2) and so on: rigid-body torques are interpolated, not approximated."""

    def torque(x: States) -> np.ndarray:
        c, s = np.cos(x.q[:, 1]), np.sin(x.q[:, 1])
        a, b = x.qdd.T
        v, w = x.qd.T
        gravity = 9.81 * np.cos(x.q.sum(axis=1))
        first = (3 + 2 * c) * a + (1 + c) * b - s * (2 * v * w + w * w)
        return np.column_stack(
            [first + gravity + 19.62 * np.cos(x.q[:, 0]), (1 + c) * a + b + s * v * v + gravity]
        )

    x, u = random_states(50, 2, 3), random_states(200, 2, 4)
    gram = kernel().cross(u, u) + 1e-9 * np.eye(400)
    weights = np.linalg.solve(gram, torque(u).ravel()).reshape(200, 2)
    error = kernel().apply(x, u, weights) - torque(x)
    assert np.abs(error).max() < 1e-4 * np.abs(torque(x)).max()
