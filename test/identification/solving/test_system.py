"""The one-factor algebra, against the same quantities written out with dense inverses."""

from dataclasses import dataclass, replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from lagrangian_ff.identification.solving.solution import NotPositiveDefiniteError
from lagrangian_ff.identification.solving.system import System

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Problem:
    """A regularised regression small enough to invert."""

    gram: Floats
    noise: Floats
    design: Floats
    target: Floats

    @classmethod
    def random(cls, size: int, columns: int, seed: int) -> "Problem":
        rng = np.random.default_rng(seed)
        root = rng.normal(size=(size, size))
        return cls(
            root @ root.T / size,
            rng.uniform(0.05, 0.2, size),
            rng.normal(size=(size, columns)),
            rng.normal(size=size),
        )

    def keep(self, rows: NDArray[np.int64]) -> "Problem":
        return Problem(
            self.gram[np.ix_(rows, rows)], self.noise[rows], self.design[rows], self.target[rows]
        )

    def system(self) -> System:
        # Only the lower triangle may be read: what lies above it comes from memory as it was.
        lower = np.where(np.tri(len(self.gram), dtype=bool), self.gram, np.nan)
        return System.factor(lower, self.noise, self.design, self.target)

    def beside(self, rests: int, seed: int) -> System:
        """Return the system of these torques and of some that a joint at rest holds back."""
        rng = np.random.default_rng(seed)
        size = len(self.target) + rests
        stuck = np.arange(size) >= len(self.target)
        gram = np.eye(size)
        root = rng.normal(size=(size, size)) / np.sqrt(size)
        gram[stuck] = (root @ root.T)[stuck]
        gram[:, stuck] = gram[stuck].T
        gram[np.ix_(~stuck, ~stuck)] = self.gram
        gram[np.ix_(stuck, stuck)] += np.eye(rests) * size
        noise = np.concatenate([self.noise, rng.uniform(1e9, 1e10, rests)])
        design = np.vstack([self.design, rng.normal(size=(rests, self.design.shape[1]))])
        target = np.concatenate([self.target, rng.normal(size=rests)])
        return System.factor(gram, noise, design, target, stuck)

    def projection(self) -> Floats:
        inverse = np.asarray(np.linalg.inv(self.gram + np.diag(self.noise)))
        carried = inverse @ self.design
        return np.asarray(inverse - carried @ np.linalg.solve(self.design.T @ carried, carried.T))


@pytest.mark.parametrize("left", [0.0, 1e-160, 1e-90])
def test_a_column_in_which_nothing_shows_gets_no_weight(left: float) -> None:
    problem = Problem.random(20, 3, seed=1)
    design = problem.design.copy()
    design[:, 1] *= left
    system = replace(problem, design=design).system()
    without = replace(problem, design=design[:, [0, 2]]).system()
    np.testing.assert_array_equal(system.coefficients[1], 0.0)
    np.testing.assert_allclose(system.weights, without.weights, rtol=1e-9)


sizes = {"size": st.integers(12, 30), "columns": st.integers(1, 4), "seed": st.integers(0, 999)}


@given(**sizes)
def test_coefficients_and_weights_solve_the_normal_equations(
    size: int, columns: int, seed: int
) -> None:
    problem = Problem.random(size, columns, seed)
    system = Problem.random(size, columns, seed).system()
    regularised = problem.gram + np.diag(problem.noise)
    residual = problem.target - problem.design @ system.coefficients
    np.testing.assert_allclose(regularised @ system.weights, residual, atol=1e-9)
    np.testing.assert_allclose(problem.design.T @ system.weights, 0.0, atol=1e-9)


@given(**sizes)
def test_evidence_is_the_restricted_likelihood(size: int, columns: int, seed: int) -> None:
    problem = Problem.random(size, columns, seed)
    system = Problem.random(size, columns, seed).system()
    regularised = problem.gram + np.diag(problem.noise)
    free = size - columns
    quadratic = problem.target @ problem.projection() @ problem.target
    amplitude = quadratic / free
    information = problem.design.T @ np.linalg.solve(regularised, problem.design)
    expected = -0.5 * (
        free * np.log(2 * np.pi * amplitude)
        + free
        + np.linalg.slogdet(regularised)[1]
        + np.linalg.slogdet(information)[1]
    )
    assert system.amplitude == pytest.approx(amplitude, rel=1e-8)
    assert system.log_evidence == pytest.approx(expected, rel=1e-8)


@given(**sizes, rests=st.integers(1, 30))
def test_torques_of_joints_at_rest_leave_the_evidence_as_it_is(
    size: int, columns: int, seed: int, rests: int
) -> None:
    problem = Problem.random(size, columns, seed)
    alone, beside = problem.system(), problem.beside(rests, seed)
    assert beside.degrees == alone.degrees
    assert beside.amplitude == pytest.approx(alone.amplitude, rel=1e-5)
    assert beside.log_evidence == pytest.approx(alone.log_evidence, abs=1e-4)
    np.testing.assert_allclose(beside.coefficients, alone.coefficients, atol=1e-5)


@given(**sizes)
def test_left_out_rows_are_predicted_as_by_a_fit_without_them(
    size: int, columns: int, seed: int
) -> None:
    problem = Problem.random(size, columns, seed)
    rng = np.random.default_rng(seed)
    order = rng.permutation(size)
    groups = [np.sort(order[:3]), np.sort(order[3:5])]
    system = Problem.random(size, columns, seed).system()
    every = list(system.left_out(groups))
    for left, weights in zip(every, system.weights_without(every).T, strict=True):
        rest = np.setdiff1d(np.arange(size), left.rows)
        without = problem.keep(rest).system()
        cross = problem.gram[np.ix_(left.rows, rest)]
        predicted = cross @ without.weights + problem.design[left.rows] @ without.coefficients
        np.testing.assert_allclose(left.residual, problem.target[left.rows] - predicted, atol=1e-7)
        moved = without.coefficients - system.coefficients
        np.testing.assert_allclose(left.change, moved, atol=1e-7)
        np.testing.assert_allclose(weights[rest], without.weights, atol=1e-7)
        np.testing.assert_allclose(weights[left.rows], 0.0, atol=1e-7)


@given(**sizes)
def test_the_papers_relaxation_tends_to_the_exact_solution(
    size: int, columns: int, seed: int
) -> None:
    """The distance of (42) with the kernel (43) falls with ρ; see (45) and (46)."""
    problem = Problem.random(size, columns, seed)
    system = problem.system()
    ours = np.concatenate([system.weights, system.coefficients])
    apart = []
    for rho in (1e-4, 1e-6):
        friction = problem.design @ problem.design.T
        kernel = problem.gram / (1.0 - rho) + friction / rho
        a = np.linalg.solve(kernel + np.diag(problem.noise), problem.target)
        theirs = np.concatenate([a / (1.0 - rho), problem.design.T @ a / rho])
        apart.append(np.abs(theirs - ours).max() / np.abs(ours).max())
    assert apart[0] < 0.1
    assert apart[1] < 0.02 * apart[0]


def test_a_column_that_never_shows_gets_no_weight() -> None:
    problem = Problem.random(20, 3, 5)
    design = problem.design.copy()
    design[:, 1] = 0.0
    full = Problem(problem.gram, problem.noise, design, problem.target).system()
    assert full.coefficients[1] == 0.0
    assert np.isfinite(full.log_evidence)
    reduced = Problem.random(20, 3, 5)
    without = Problem(
        reduced.gram, reduced.noise, np.delete(problem.design, 1, axis=1), reduced.target
    ).system()
    np.testing.assert_allclose(full.coefficients[[0, 2]], without.coefficients, atol=1e-10)


def test_a_column_that_stands_twice_shares_its_weight() -> None:
    problem = Problem.random(20, 2, 6)
    twice = Problem(
        problem.gram.copy(), problem.noise, problem.design[:, [0, 1, 1]], problem.target
    ).system()
    once = problem.system()
    assert twice.coefficients[1] == pytest.approx(twice.coefficients[2])
    np.testing.assert_allclose(
        [twice.coefficients[0], 2 * twice.coefficients[1]], once.coefficients, atol=1e-8
    )
    assert twice.degrees == once.degrees


def test_a_matrix_that_is_not_positive_definite_is_refused() -> None:
    gram = np.diag([1.0, -2.0, 1.0])
    with pytest.raises(NotPositiveDefiniteError, match="pivot 2 of 3"):
        System.factor(gram, np.full(3, 0.1), np.zeros((3, 0)), np.ones(3))


@pytest.mark.parametrize("value", [np.inf, np.nan])
def test_a_matrix_that_is_not_finite_is_refused(value: float) -> None:
    gram = np.diag([1.0, value, 1.0])
    with pytest.raises(NotPositiveDefiniteError, match="3"):
        System.factor(gram, np.full(3, 0.1), np.zeros((3, 0)), np.ones(3))


@pytest.mark.parametrize(("scale", "tolerance"), [(1.0, 1e-9), (1e14, 1e-4)])
def test_columns_of_some_rows_explain_beside_others_as_much_as_in_a_fit(
    scale: float, tolerance: float
) -> None:
    """They do so even if the noise is hardly large enough for a factor."""
    problem = Problem.random(40, 4, seed=3)
    low = replace(problem, gram=scale * problem.gram[:, :8] @ problem.gram[:, :8].T)
    rows = np.arange(0, 40, 2)
    column = np.random.default_rng(4).normal(size=len(rows))
    system, known = low.system(), low.design[:, [0, 2]]
    span, _ = np.linalg.qr(system.white_design[:, [0, 2]])
    upper, target, squares = system.seen_by(rows, span)
    both = np.column_stack([known, np.zeros(40)])
    both[rows, -1] = column
    own = upper @ column
    left = squares - (own @ target) ** 2 / (own @ own)
    assert squares == pytest.approx(replace(low, design=known).system().squares, rel=tolerance)
    assert left == pytest.approx(replace(low, design=both).system().squares, rel=tolerance)


def test_another_basis_takes_the_same_factor() -> None:
    problem, other = Problem.random(25, 3, seed=5), Problem.random(25, 2, seed=6)
    found = problem.system().of(other.design, other.target)
    fresh = replace(problem, design=other.design, target=other.target).system()
    np.testing.assert_allclose(found.weights, fresh.weights, rtol=1e-12)
    assert found.log_evidence == pytest.approx(fresh.log_evidence, rel=1e-12)
