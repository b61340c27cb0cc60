"""Maximising a log density: where it ends, and what it must never do."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from lagrangian_ff.identification.choosing.levenberg_marquardt import (
    PRIOR_DEVIATION,
    RARITY,
    Density,
    Derivatives,
    HyperPrior,
)
from lagrangian_ff.identification.solving.solution import NotPositiveDefiniteError

Floats = NDArray[np.float64]


def parabola(top: Floats, width: Floats) -> Density[Floats]:
    """Return a density whose curvature is known exactly, with the prior's middle at zero."""

    def derivatives(point: Floats) -> Derivatives:
        return Derivatives(-(point - top) / width**2, np.diag(1.0 / width**2))

    return Density(
        HyperPrior(np.zeros(len(top))),
        lambda point: point,
        lambda point: -0.5 * float(np.sum(((point - top) / width) ** 2)),
        derivatives,
    )


def test_the_top_is_where_evidence_and_prior_balance() -> None:
    top, width = np.array([2.0, -1.0, 4.0]), np.array([0.1, 1.0, 3.0])
    found, _ = parabola(top, width).maximised(np.zeros(3), 40)
    precision = 1.0 / width**2
    expected = top * precision / (precision + 1.0 / PRIOR_DEVIATION**2)
    # It ends where a step brings less than a twentieth of a nat.
    off = (found - expected) ** 2 * (precision + 1.0 / PRIOR_DEVIATION**2)
    assert 0.5 * off.sum() < 0.05


def test_the_prior_holds_what_the_evidence_leaves_open() -> None:
    quadratic = parabola(np.array([3.0, 0.0]), np.array([0.5, 1e9]))
    found, _ = quadratic.maximised(np.zeros(2), 20)
    assert found[0] == pytest.approx(3.0, abs=0.2)
    assert found[1] == pytest.approx(0.0, abs=1e-12)


def test_it_ends_where_its_range_does() -> None:
    quadratic = replace(
        parabola(np.array([3.0, 1.0]), np.ones(2)), inside=lambda x: np.minimum(x, [2.0, 9.0])
    )
    found, _ = quadratic.maximised(np.zeros(2), 20)
    assert found[0] == 2.0
    assert found[1] == pytest.approx(1.0 / (1.0 + PRIOR_DEVIATION**-2), abs=0.2)


@settings(max_examples=30)
@given(seed=st.integers(0, 9999))
def test_the_density_never_falls_even_with_wrong_derivatives(seed: int) -> None:
    """Wrong derivatives, and points without a factor, cost steps only."""
    rng = np.random.default_rng(seed)
    waves = rng.normal(size=(4, 2))

    def at(point: Floats) -> Floats:
        if point[0] > 1.0:
            raise NotPositiveDefiniteError("a cliff")
        return point

    def density(point: Floats) -> float:
        return float(np.sum(np.sin(waves @ point)))

    def derivatives(point: Floats) -> Derivatives:
        return Derivatives(5.0 * rng.normal(size=2), np.eye(2) * rng.uniform(0.1, 2.0))

    start = np.array([0.5, 0.5])
    found, place = Density(HyperPrior(start), at, density, derivatives).maximised(start, 15)
    np.testing.assert_array_equal(found, place)
    assert found[0] <= 1.0
    assert density(found) >= density(start)


def test_a_first_point_without_a_factor_is_refused() -> None:
    def at(point: Floats) -> Floats:
        raise NotPositiveDefiniteError("a bog")

    quadratic = Density(
        HyperPrior(np.zeros(1)), at, lambda place: 0.0, lambda place: Derivatives(place, np.eye(1))
    )
    with pytest.raises(NotPositiveDefiniteError, match="bog"):
        quadratic.maximised(np.zeros(1), 3)


@given(seed=st.integers(0, 9999))
def test_derivatives_of_the_prior_are_those_of_finite_differences(seed: int) -> None:
    rng = np.random.default_rng(seed)
    middle, point = rng.normal(size=(2, 4))
    prior = HyperPrior(middle, np.array([1.0, 0.0, 1.0, 0.0]))
    found = prior.derivatives(point)
    step = 1e-4
    for n, e in enumerate(step * np.eye(4)):
        up, here, down = (prior.log_density(point + way * e) for way in (1.0, 0.0, -1.0))
        np.testing.assert_allclose(found.gradient[n], (up - down) / (2 * step), rtol=1e-6)
        bend = (up - 2.0 * here + down) / step**2
        np.testing.assert_allclose(found.curvature[n, n], -bend, rtol=1e-4)
    np.testing.assert_array_equal(found.curvature, np.diag(np.diag(found.curvature)))


def test_a_torque_many_times_as_large_is_improbable() -> None:
    """Another logarithm may go as far for a few nats; that of a variance may become small."""
    hundredfold = np.array([2.0 * np.log(100.0)])
    free, held = HyperPrior(np.zeros(1)), HyperPrior(np.zeros(1), np.ones(1))
    assert free.log_density(hundredfold) > -5.0
    assert held.log_density(hundredfold) < -99.0 * RARITY
    assert held.log_density(-hundredfold) > held.log_density(np.zeros(1)) - 5.0
