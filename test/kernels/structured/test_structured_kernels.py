"""Kernels of mechanical Lagrangians, against symbolic derivatives, and a chain as a polynomial."""

from collections.abc import Callable

import numpy as np
import pytest
import sympy
from numpy.typing import NDArray

from lagrangian_ff.kernels import KERNELS, Chain, ChainRbf, Energy, EnergyRbf, States
from lagrangian_ff.kernels.structured.base import BELL, COSINE, BlockSum, Structured
from lagrangian_ff.kernels.structured.chain import MOST_JOINTS, Polynomial

Floats = NDArray[np.float64]
Symbols = tuple[sympy.Symbol, ...]

STRUCTURED: list[type[Structured]] = [Chain, ChainRbf, Energy, EnergyRbf]


def random_states(samples: int, joints: int, seed: int) -> States:
    rng = np.random.default_rng(seed)
    q, qd, qdd = (scale * rng.normal(size=(samples, joints)) for scale in (1.5, 1.0, 3.0))
    return States.of(q, qd, qdd)


def random_kernel(kind: type[Structured], joints: int, seed: int, sliding: int = -1) -> Structured:
    rng = np.random.default_rng(seed)
    start = kind.start(random_states(5, joints, seed))
    values = {
        name: rng.uniform(0.3, 2.0, len(value)) for name, value in start.hyperparameters.items()
    }
    values["prismatic"] = (np.arange(joints) == sliding).astype(float)
    return start.replace(**values)


def definition(kernel: Structured, q: Symbols, v: Symbols, p: Symbols, u: Symbols) -> sympy.Expr:
    """k_L as it is written down in the modules, nothing differentiated."""
    joints = range(len(q))

    def factor(n: int, omega: float) -> sympy.Expr:
        d = q[n] - p[n]
        if kernel.prismatic[n]:
            return sympy.exp(-omega * d**2 / 2)
        if kernel.form == COSINE:
            return (1 + omega * sympy.cos(d)) / (1 + omega)
        assert kernel.form == BELL
        return sympy.exp(-omega * (1 - sympy.cos(d)))

    c = [factor(n, kernel.wave[n]) for n in joints]
    g = [factor(n, kernel.swing[n]) for n in joints]
    t = [kernel.inertia[n] * v[n] * u[n] for n in joints]
    rotors = sum(kernel.rotor[n] * t[n] ** 2 / 4 for n in joints)
    if not kernel.serial:
        kinetic = kernel.link[0] * sum(t) ** 2 / 2 * sympy.prod([x**2 for x in c])
        return kinetic + kernel.potential[0] * sympy.prod(g) + rotors
    kinetic = sum(
        t[j] * t[k] / 2
        * sympy.prod(c[min(j, k) + 1 : max(j, k) + 1])
        * kernel.link[i] * sympy.prod([x**2 for x in c[max(j, k) + 1 : i + 1]])
        for j in joints for k in joints for i in joints if i >= max(j, k)
    )  # fmt: skip
    return kinetic + sum(kernel.potential[i] * sympy.prod(g[: i + 1]) for i in joints) + rotors


def symbolic_block(kernel: Structured, x: States, u: States) -> Floats:
    """K (N, N) for one pair: the Euler-Lagrange operator applied twice to the definition."""
    count = x.joints
    first = [sympy.symbols(f"x{name}:{count}") for name in ("q", "qd", "qdd")]
    second = [sympy.symbols(f"u{name}:{count}") for name in ("q", "qd", "qdd")]
    total = definition(kernel, first[0], first[1], second[0], second[1])

    def euler_lagrange(f: sympy.Expr, state: list[Symbols], n: int) -> sympy.Expr:
        q, qd, qdd = state
        momentum = sympy.diff(f, qd[n])
        change = sum(sympy.diff(momentum, q[k]) * qd[k] for k in range(count))
        change += sum(sympy.diff(momentum, qd[k]) * qdd[k] for k in range(count))
        return change - sympy.diff(f, q[n])

    rows = [euler_lagrange(total, second, m) for m in range(count)]
    block = [euler_lagrange(row, first, n) for n in range(count) for row in rows]
    symbols = [s for state in (first, second) for group in state for s in group]
    values = [float(v) for s in (x, u) for part in (s.q, s.qd, s.qdd) for v in part[0]]
    found = sympy.lambdify(symbols, block, "numpy", cse=True)(*values)
    return np.reshape(np.array(found, dtype=np.float64), (count, count))


@pytest.mark.parametrize("kind", STRUCTURED)
@pytest.mark.parametrize(("joints", "sliding"), [(1, -1), (2, 0), (2, -1), (3, 1)])
def test_it_is_its_definition_pushed_through_euler_lagrange_twice(
    kind: type[Structured], joints: int, sliding: int
) -> None:
    kernel = random_kernel(kind, joints, 3, sliding)
    x, u = random_states(1, joints, 1), random_states(1, joints, 101)
    expected = symbolic_block(kernel, x, u)
    np.testing.assert_allclose(kernel.cross(x, u), expected, atol=1e-12 * abs(expected).max())


def random_contraction(size: int) -> tuple[Floats, Floats]:
    """Symmetric weights and a vector."""
    rng = np.random.default_rng(0)
    weights = rng.normal(size=(size, size))
    return weights + weights.T, rng.normal(size=size)


@pytest.mark.parametrize("kind", STRUCTURED)
@pytest.mark.parametrize(("joints", "sliding"), [(1, -1), (4, -1), (4, 1), (7, -1)])
def test_derivatives_by_hyperparameters_are_those_of_differences(
    kind: type[Structured], joints: int, sliding: int
) -> None:
    kernel, x = random_kernel(kind, joints, 5, sliding), random_states(40, joints, 2)
    weights, vector = random_contraction(40 * joints)

    found = kernel.contract(x, np.tril(weights), vector)
    assert set(found) == set(kernel.differentiable)
    for name, derivative in found.items():
        value = kernel.hyperparameters[name]
        for place, step in enumerate(1e-4 * np.eye(len(value)) * value):
            up, down = (kernel.replace(**{name: value + sign * step}) for sign in (1.0, -1.0))
            slope = (up.cross(x, x) - down.cross(x, x)) / (2.0 * step.sum())
            expected, scale = slope @ vector, max(1.0, float(np.abs(slope).max()))
            np.testing.assert_allclose(derivative.product[place], expected, atol=1e-5 * scale)
            expected = float(np.sum(weights * slope))
            np.testing.assert_allclose(derivative.total[place], expected, atol=1e-4 * scale)


@pytest.mark.parametrize("kind", STRUCTURED)
@pytest.mark.parametrize("spread", [1.0, 1000.0])
def test_derivatives_add_up_to_the_kernel(kind: type[Structured], spread: float) -> None:
    """Euler: K is linear in link, potential and rotor, and but for gravity a square in inertia."""
    kernel, x = random_kernel(kind, 5, 3, 2), random_states(70, 5, 4)
    kernel = kernel.replace(inertia=kernel.inertia * spread ** np.linspace(-1.0, 1.0, 5))
    weights, vector = random_contraction(350)
    gram = kernel.cross(x, x)
    whole = np.append(gram @ vector, np.sum(weights * gram))
    found = kernel.contract(x, np.tril(weights), vector)

    def along(name: str) -> Floats:
        value = kernel.hyperparameters[name]
        return np.append(value @ found[name].product, value @ found[name].total)

    tolerance = 1e-10 * np.append(np.full(350, np.abs(whole[:-1]).max()), np.abs(gram).sum())
    linear = along("link") + along("potential") + along("rotor")
    assert (abs(linear - whole) < tolerance).all()
    square = 2.0 * (whole - along("potential"))
    assert (abs(along("inertia") - square) < tolerance).all()


def double_pendulum(x: States) -> Floats:
    """Two equal links of 1 m and 1 kg, gravity 9.81 m/s²."""
    c, s = np.cos(x.q[:, 1]), np.sin(x.q[:, 1])
    a, b = x.qdd.T
    v, w = x.qd.T
    gravity = 9.81 * np.cos(x.q.sum(axis=1))
    first = (3 + 2 * c) * a + (1 + c) * b - s * (2 * v * w + w * w)
    return np.column_stack(
        [first + gravity + 19.62 * np.cos(x.q[:, 0]), (1 + c) * a + b + s * v * v + gravity]
    )


def slide_on_a_turntable(x: States) -> Floats:
    """A mass of 1 kg that slides along a horizontal arm turning with inertia 1 kg m²."""
    r, (v, s), (a, b) = x.q[:, 1], x.qd.T, x.qdd.T
    return np.column_stack([(1 + r * r) * a + 2 * r * v * s, b - r * v * v])


def error_of(kernel: Structured, torque: Callable[[States], Floats], samples: int) -> float:
    """Error on unseen states after learning, relative to the spread of the torque."""
    x, u = random_states(50, 2, 3), random_states(samples, 2, 4)
    gram = kernel.cross(u, u)
    gram += 1e-13 * np.trace(gram) / len(gram) * np.eye(len(gram))
    weights = np.asarray(np.linalg.solve(gram, torque(u).ravel()).reshape(samples, 2), np.float64)
    error = kernel.apply(x, u, weights) - torque(x)
    return float(np.std(error) / np.std(torque(x)))


@pytest.mark.parametrize(("kind", "samples"), [(Chain, 12), (Energy, 100)])
def test_cosine_factors_hold_a_double_pendulum_exactly(
    kind: type[Structured], samples: int
) -> None:
    kernel = kind.start(random_states(50, 2, 4))
    assert error_of(kernel, double_pendulum, samples) < 1e-8


@pytest.mark.parametrize("kind", [Chain, Energy])
def test_a_sliding_joint_is_learned_when_it_is_said_to_slide(kind: type[Structured]) -> None:
    kernel = kind.start(random_states(50, 2, 4))
    long = np.array([1.0, 0.02])
    slides = {"prismatic": np.array([0.0, 1.0]), "wave": long, "swing": long}
    told = error_of(kernel.replace(**slides), slide_on_a_turntable, 150)
    assert told < 0.01
    assert error_of(kernel, slide_on_a_turntable, 150) > 10.0 * told


@pytest.mark.parametrize("joints", [1, 2, 3, 6])
def test_the_torques_are_those_of_the_sum(joints: int) -> None:
    kernel = random_kernel(Chain, joints, 3)
    u, x = random_states(150, joints, 1), random_states(9, joints, 2)
    a = np.random.default_rng(0).normal(size=(150, joints))
    learned = kernel.learned(u, a)
    assert isinstance(learned, Polynomial)
    expected = kernel.apply(x, u, a)
    np.testing.assert_allclose(learned.torque(x), expected, atol=1e-12 * abs(expected).max())


def test_a_joint_that_slides_has_no_polynomial() -> None:
    kernel = random_kernel(Chain, 3, 3, sliding=1)
    assert isinstance(kernel.learned(random_states(5, 3, 1), np.ones((5, 3))), BlockSum)


def test_too_many_joints_stay_a_sum() -> None:
    joints = MOST_JOINTS + 1
    kernel = random_kernel(Chain, joints, 3)
    assert isinstance(kernel.learned(random_states(5, joints, 1), np.ones((5, joints))), BlockSum)


@pytest.mark.parametrize("name", sorted(KERNELS))
def test_every_kernel_learns_what_it_applies(name: str) -> None:
    u, x = random_states(8, 3, 1), random_states(5, 3, 2)
    kernel, a = KERNELS[name].start(u), np.random.default_rng(0).normal(size=(8, 3))
    expected = kernel.apply(x, u, a)
    scale = max(1.0, float(abs(expected).max()))
    np.testing.assert_allclose(kernel.learned(u, a).torque(x), expected, atol=1e-12 * scale)
