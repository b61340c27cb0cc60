"""The push-forward through the Euler-Lagrange operator, against derivations that share no code."""

from pathlib import Path

import numpy as np
import pytest
import sympy
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray
from test_kernel_list import dense, random_states

from lagrangian_ff.kernels import KERNELS, States
from lagrangian_ff.kernels.lagrangian import Srbf, Srbfs, Svrbf, Svrbfs, Vrbf, Vrbfs

Floats = NDArray[np.float64]

SIGMA, C = 1.7, 0.8
W = C / SIGMA**0.5
VECTOR: list[type[Vrbf] | type[Vrbfs]] = [Vrbf, Vrbfs]
SCALAR: list[
    tuple[type[Vrbf] | type[Vrbfs], type[Svrbf] | type[Svrbfs] | type[Srbf] | type[Srbfs]]
] = [(Vrbf, Svrbf), (Vrbfs, Svrbfs), (Vrbf, Srbf), (Vrbfs, Srbfs)]


def make(family: type[Vrbf] | type[Vrbfs]) -> Vrbf | Vrbfs:
    return family(np.array([SIGMA]), np.array([C]))


def symbolic_block(angles: bool, x: States, u: States) -> tuple[Floats, Floats]:
    """K (2, 2) and the row (34) (2,) for one pair, by symbolic differentiation of (17) twice."""
    names = ("q", "qd", "qdd")
    first = [sympy.symbols(f"x{name}:2") for name in names]
    second = [sympy.symbols(f"u{name}:2") for name in names]

    def features(q: tuple[sympy.Symbol, ...]) -> list[sympy.Expr]:
        return [f(s) for s in q for f in (sympy.cos, sympy.sin)] if angles else list(q)

    squared = sum(
        (a - b) ** 2 for a, b in zip(features(first[0]), features(second[0]), strict=True)
    )
    squared += sum(C**2 * (a - b) ** 2 for a, b in zip(first[1], second[1], strict=True))
    lagrangian = sympy.exp(-squared / (2 * SIGMA))

    def euler_lagrange(f: sympy.Expr, state: list[tuple[sympy.Symbol, ...]], n: int) -> sympy.Expr:
        q, qd, qdd = state
        momentum = sympy.diff(f, qd[n])
        rate = sum(sympy.diff(momentum, q[k]) * qd[k] for k in range(2))
        rate += sum(sympy.diff(momentum, qd[k]) * qdd[k] for k in range(2))
        return rate - sympy.diff(f, q[n])

    rows = [euler_lagrange(lagrangian, second, m) for m in range(2)]
    block = [[euler_lagrange(row, first, n) for row in rows] for n in range(2)]
    symbols = [s for state in (first, second) for group in state for s in group]
    values = [float(v) for s in (x, u) for part in (s.q, s.qd, s.qdd) for v in part[0]]
    evaluate = sympy.lambdify(symbols, [*block[0], *block[1], *rows], "numpy")
    found = np.array(evaluate(*values), dtype=float)
    return found[:4].reshape(2, 2), found[4:]


@pytest.mark.parametrize("family", VECTOR)
def test_blocks_equal_symbolic_differentiation(family: type[Vrbf] | type[Vrbfs]) -> None:
    x, u = random_states(1, 2, 10), random_states(1, 2, 11)
    block, row = symbolic_block(family.angles, x, u)
    np.testing.assert_allclose(make(family).cross(x, u), block, atol=1e-14)
    np.testing.assert_allclose(make(family).lagrangian_row(x, u)[0, 0], row, atol=1e-14)


def closed_form(angles: bool, x: States, u: States) -> Floats:
    """K (3, 3) of one pair as eq. (37) prints it, c_y written c_u and ∂φ_u the last of K_2."""
    n = x.joints

    def mapped(s: States) -> tuple[Floats, Floats, Floats, Floats]:
        """φ, its Jacobian, ψ and the rate of ψ, eqs. (38), (39)."""
        q, slope = s.q[0], np.eye(n)
        if angles:
            slope = np.vstack([-np.diag(np.sin(q)), np.diag(np.cos(q))])
            q = np.concatenate([np.cos(q), np.sin(q)])
        return q / SIGMA**0.5, slope / SIGMA**0.5, W * s.qd[0], W * s.qdd[0]

    (px, dpx, sx, rx), (pu, dpu, su, ru) = mapped(x), mapped(u)
    px_rate, pu_rate = dpx @ x.qd[0], dpu @ u.qd[0]
    a, b, o, ds = px - pu, sx - su, np.outer, W * np.eye(n)
    c_x, c_u = a @ px_rate + b @ rx, a @ pu_rate + b @ ru
    c_xu = c_x * c_u - (px_rate @ pu_rate + rx @ ru)
    first = dpx.T @ (np.eye(len(a)) - o(a, a)) @ dpu
    second = -ds.T @ (c_x * o(b, a) - (o(rx, a) + o(b, px_rate))) @ dpu
    third = dpx.T @ (c_u * o(a, b) - (o(pu_rate, b) + o(a, ru))) @ ds
    middle = c_xu * (o(b, b) - np.eye(n)) + o(ru, rx) + o(rx, ru)
    middle -= c_x * (o(ru, b) + o(b, ru)) + c_u * (o(rx, b) + o(b, rx))
    total = first + second + third + ds.T @ middle @ ds
    return np.asarray(np.exp(-0.5 * (a @ a + b @ b)) * total)


@pytest.mark.parametrize("family", VECTOR)
def test_blocks_equal_the_papers_closed_form(family: type[Vrbf] | type[Vrbfs]) -> None:
    for seed in range(5):
        x, u = random_states(1, 3, seed), random_states(1, 3, 50 + seed)
        expected = closed_form(family.angles, x, u)
        np.testing.assert_allclose(make(family).cross(x, u), expected, atol=1e-13)


@pytest.mark.parametrize("joints", [1, 2, 3, 6])
@pytest.mark.parametrize("family", VECTOR)
def test_blocks_equal_automatic_differentiation(
    family: type[Vrbf] | type[Vrbfs], joints: int, shared: Path
) -> None:
    file = shared / "reference" / "lagrangian_kernels.npz"
    if not file.is_file():
        pytest.skip("no reference values: ../shared/reference is absent")
    with np.load(file) as reference:
        x, u = (
            States.of(*(reference[f"n{joints}_{side}_{part}"] for part in ("q", "qd", "qdd")))
            for side in "xu"
        )
        block = reference[f"n{joints}_{family.name}"]
        row = reference[f"n{joints}_{family.name}_lagrangian_row"]
    kernel = make(family)
    found = dense(kernel, x, u).transpose(0, 2, 1, 3)
    np.testing.assert_allclose(found, block, atol=1e-15 * max(1.0, abs(block).max()))
    np.testing.assert_allclose(kernel.lagrangian_row(x, u), row, atol=1e-15)


@pytest.mark.parametrize(("vector", "scalar"), SCALAR)
def test_scalar_kernels_are_the_diagonal(
    vector: type[Vrbf] | type[Vrbfs], scalar: type[Svrbf] | type[Svrbfs] | type[Srbf] | type[Srbfs]
) -> None:
    """Eq. (30), and (35) where all joints are given the same hyperparameters."""
    x, u = random_states(4, 3, 12), random_states(5, 3, 13)
    blocks = dense(make(vector), x, u)
    kernel = scalar(np.array([SIGMA]), np.array([C]))
    for joint in range(3):
        np.testing.assert_allclose(
            kernel.cross(x, u, joint), blocks[:, joint, :, joint], atol=1e-14
        )


@given(factor=st.floats(0.1, 10.0), seed=st.integers(0, 50))
@pytest.mark.parametrize("name", ["vrbf", "vrbfs", "srbf", "svrbfs"])
def test_time_may_be_measured_in_any_unit(name: str, factor: float, seed: int) -> None:
    """Dividing qd by s and qdd by s², with c times s, leaves torques as they were."""
    x, u = random_states(3, 2, seed), random_states(3, 2, seed + 7)
    kernel = KERNELS[name].start(x)
    slow = kernel.replace(velocity_scale=kernel.hyperparameters["velocity_scale"] * factor)
    before = dense(kernel, x, u)
    after = dense(
        slow,
        States.of(x.q, x.qd / factor, x.qdd / factor**2),
        States.of(u.q, u.qd / factor, u.qdd / factor**2),
    )
    np.testing.assert_allclose(after, before, atol=1e-12 * max(1.0, abs(before).max()))


@given(a=st.floats(-2, 2), b=st.floats(-2, 2), seed=st.integers(0, 50))
@pytest.mark.parametrize("name", ["vrbf", "vrbfs", "svrbfs"])
def test_torque_is_affine_in_acceleration(name: str, a: float, b: float, seed: int) -> None:
    """τ = M(q, qd) qdd + h: what a Lagrangian gives, whatever the kernel has learned."""
    u, x = random_states(6, 2, seed), random_states(1, 2, seed + 1)
    kernel = KERNELS[name].start(u)
    weights = np.random.default_rng(seed).normal(size=(6, 2))

    def torque(qdd: Floats) -> Floats:
        return kernel.apply(States.of(x.q, x.qd, qdd), u, weights)

    first, second, rest = torque(x.qdd), torque(x.qdd[:, ::-1]), torque(0.0 * x.qdd)
    mixed = torque(a * x.qdd + b * x.qdd[:, ::-1])
    expected = rest + a * (first - rest) + b * (second - rest)
    np.testing.assert_allclose(mixed, expected, atol=1e-9 * max(1.0, abs(expected).max()))


@pytest.mark.parametrize("family", VECTOR)
def test_energy_of_what_was_learned_is_balanced(family: type[Vrbf] | type[Vrbfs]) -> None:
    """τᵀ qd is the rate of qd·∂L/∂qd − L along any motion: one Lagrangian stands behind K."""
    u = random_states(5, 2, 20)
    kernel = make(family)
    weights = np.random.default_rng(21).normal(size=(5, 2))

    def lagrangian(q: Floats, qd: Floats) -> Floats:
        rows = kernel.lagrangian_row(States.of(q, qd, np.zeros_like(q)), u)
        return np.einsum("ijm,jm->i", rows, weights)

    def energy(q: Floats, qd: Floats) -> Floats:
        step = 1e-5
        return (lagrangian(q, qd * (1 + step)) - lagrangian(q, qd * (1 - step))) / (
            2 * step
        ) - lagrangian(q, qd)

    t, step = np.linspace(0.0, 2.0, 40), 1e-4

    def motion(t: Floats) -> tuple[Floats, Floats, Floats]:
        phase = np.stack([1.3 * t, 0.7 * t + 1.0], axis=1)
        rate = np.array([1.3, 0.7])
        return np.sin(phase), rate * np.cos(phase), -(rate**2) * np.sin(phase)

    q, qd, qdd = motion(t)
    power = np.sum(kernel.apply(States.of(q, qd, qdd), u, weights) * qd, axis=1)
    later, earlier = motion(t + step), motion(t - step)
    rate = (energy(*later[:2]) - energy(*earlier[:2])) / (2 * step)
    np.testing.assert_allclose(power, rate, atol=2e-5 * abs(power).max())
