"""Climbing: slopes against finite differences, and what a climb must never do."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from lagrangian_ff.identification.choosing.ascent import Hill, Slopes, numbers, slopes_by_gram
from lagrangian_ff.identification.choosing.belief import PRIOR_DEVIATION, Belief
from lagrangian_ff.identification.solving.solution import NotPositiveDefiniteError
from lagrangian_ff.identification.solving.system import System
from lagrangian_ff.kernels import KERNELS, DifferentiableKernel, States

Floats = NDArray[np.float64]

SAMPLES, JOINTS = 9, 2
DIFFERENTIABLE = sorted(n for n, k in KERNELS.items() if issubclass(k, DifferentiableKernel))
SECOND: dict[str, Callable[[np.random.Generator], Floats | None]] = {
    "one matrix": lambda rng: None,
    "a second one": lambda rng: rng.uniform(0.0, 1.0, SAMPLES * JOINTS),
}
TRUST: dict[str, Callable[[np.random.Generator], Floats | None]] = {
    "all trusted": lambda rng: None,
    "some doubted": lambda rng: rng.uniform(0.1, 1.0, (SAMPLES, JOINTS)),
}


@pytest.mark.parametrize("name", DIFFERENTIABLE)
@pytest.mark.parametrize("second", SECOND)
@pytest.mark.parametrize("trust", TRUST)
def test_slopes_are_those_of_finite_differences(name: str, second: str, trust: str) -> None:
    rng = np.random.default_rng(5)
    x = States.of(*rng.normal(size=(3, SAMPLES, JOINTS)))
    kernel = KERNELS[name].start(x)
    assert isinstance(kernel, DifferentiableKernel)
    design, target = rng.normal(size=(SAMPLES * JOINTS, 2)), rng.normal(size=SAMPLES * JOINTS)
    also, believed = SECOND[second](rng), TRUST[trust](rng)
    values = numbers(kernel)
    middle = np.log(np.concatenate([*values.values(), np.array([0.3, 0.1])]))

    def at(point: Floats) -> tuple[DifferentiableKernel, Floats, System]:
        left = np.exp(point)
        changed = {}
        for one, value in values.items():
            changed[one], left = left[: len(value)], left[len(value) :]
        there = kernel.replace(**changed)
        assert isinstance(there, DifferentiableKernel)
        gram = there.gram(x)
        if also is not None:
            gram = gram * (1.0 + np.outer(also, also))
        each = np.tile(left, (SAMPLES, 1)) / (1.0 if believed is None else believed)
        return there, left, System.factor(gram, each.ravel(), design, target)

    there, noise, system = at(middle)
    found = slopes_by_gram(system, there, x, noise, also, believed)
    step = 1e-5
    expected = [
        (at(middle + e)[2].log_evidence - at(middle - e)[2].log_evidence) / (2 * step)
        for e in step * np.eye(len(middle))
    ]
    np.testing.assert_allclose(found.slope, expected, atol=2e-6, rtol=1e-5)
    np.testing.assert_allclose(found.information, found.information.T, atol=1e-10)
    assert np.linalg.eigvalsh(found.information).min() > -1e-8


def parabola(top: Floats, width: Floats) -> Hill[Floats]:
    """A hill whose curvature is known exactly, with the prior's middle at zero."""

    def slopes(point: Floats) -> Slopes:
        return Slopes(-(point - top) / width**2, np.diag(1.0 / width**2))

    return Hill(
        Belief(np.zeros(len(top))),
        lambda point: point,
        lambda point: -0.5 * float(np.sum(((point - top) / width) ** 2)),
        slopes,
    )


def test_the_top_is_where_evidence_and_prior_balance() -> None:
    top, width = np.array([2.0, -1.0, 4.0]), np.array([0.1, 1.0, 3.0])
    found, _ = parabola(top, width).climb(np.zeros(3), 40)
    precision = 1.0 / width**2
    expected = top * precision / (precision + 1.0 / PRIOR_DEVIATION**2)
    # A climb ends where a step brings less than a twentieth of a nat.
    off = (found - expected) ** 2 * (precision + 1.0 / PRIOR_DEVIATION**2)
    assert 0.5 * off.sum() < 0.05


def test_the_prior_holds_what_the_heights_say_nothing_about() -> None:
    hill = parabola(np.array([3.0, 0.0]), np.array([0.5, 1e9]))
    found, _ = hill.climb(np.zeros(2), 20)
    assert found[0] == pytest.approx(3.0, abs=0.2)
    assert found[1] == pytest.approx(0.0, abs=1e-12)


def test_a_climb_ends_where_its_range_does() -> None:
    hill = replace(parabola(np.array([3.0, 1.0]), np.ones(2)), low=-np.inf, high=np.array([2, 9]))
    found, _ = hill.climb(np.zeros(2), 20)
    assert found[0] == 2.0
    assert found[1] == pytest.approx(1.0 / (1.0 + PRIOR_DEVIATION**-2), abs=0.2)


@settings(max_examples=30)
@given(seed=st.integers(0, 9999))
def test_a_climb_never_goes_down_whatever_the_slopes_say(seed: int) -> None:
    """Slopes that mislead, and places where nobody can stand, cost height at most."""
    rng = np.random.default_rng(seed)
    waves = rng.normal(size=(4, 2))

    def go(point: Floats) -> Floats:
        if point[0] > 1.0:
            raise NotPositiveDefiniteError("a cliff")
        return point

    def height(point: Floats) -> float:
        return float(np.sum(np.sin(waves @ point)))

    def slopes(point: Floats) -> Slopes:
        return Slopes(5.0 * rng.normal(size=2), np.eye(2) * rng.uniform(0.1, 2.0))

    start = np.array([0.5, 0.5])
    found, place = Hill(Belief(start), go, height, slopes).climb(start, 15)
    np.testing.assert_array_equal(found, place)
    assert found[0] <= 1.0
    assert height(found) >= height(start)


def test_where_nobody_can_stand_at_first_there_is_no_climb() -> None:
    def go(point: Floats) -> Floats:
        raise NotPositiveDefiniteError("a bog")

    hill = Hill(Belief(np.zeros(1)), go, lambda place: 0.0, lambda place: Slopes(place, np.eye(1)))
    with pytest.raises(NotPositiveDefiniteError, match="bog"):
        hill.climb(np.zeros(1), 3)
