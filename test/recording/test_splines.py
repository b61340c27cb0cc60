"""Splines, held against those of SciPy."""

import numpy as np
import pytest
from scipy.interpolate import CubicSpline, make_lsq_spline

from lagrangian_ff.recording.splines import LeastSquares, interpolate, slopes

RNG = np.random.default_rng(0)


def times(count: int) -> np.ndarray:
    """Return increasing times that are not even."""
    return np.cumsum(RNG.uniform(0.5, 1.5, count))


@pytest.mark.parametrize("count", [4, 5, 6, 500])
def test_the_spline_through_samples_is_that_of_scipy(count: int) -> None:
    time, values = times(count), RNG.normal(size=count)
    at = np.sort(RNG.uniform(time[0], time[-1], 300))
    known = CubicSpline(time, values)
    np.testing.assert_allclose(interpolate(time, values, at), known(at), atol=1e-11)
    np.testing.assert_allclose(slopes(time, values), known(time, 1), atol=1e-11)


def test_samples_stay_where_they_are() -> None:
    time, values = times(50), RNG.normal(size=50)
    np.testing.assert_allclose(interpolate(time, values, time), values, atol=1e-14)


@pytest.mark.parametrize("pieces", [2, 3, 7])
def test_the_nearest_spline_and_its_slope_are_those_of_scipy(pieces: int) -> None:
    x = times(400)
    values = np.sin(3.0 * x / x[-1]) + 0.1 * RNG.normal(size=400)
    inner = np.linspace(x[0], x[-1], pieces + 1)[1:-1]
    known = make_lsq_spline(x, values, np.concatenate([[x[0]] * 4, inner, [x[-1]] * 4]), k=3)
    near = LeastSquares(x, pieces)
    np.testing.assert_allclose(near.values(near.fit(values)), known(x), atol=1e-4)
    np.testing.assert_allclose(near.slopes(near.fit(values)), known(x, 1), atol=1e-2)


def test_the_nearest_spline_goes_on_through_a_pause() -> None:
    x = np.concatenate([np.linspace(0.0, 1.0, 200), np.linspace(1.4, 2.0, 120)])
    near = LeastSquares(x, 20)
    found = near.values(near.fit(np.sin(3.0 * x)))
    np.testing.assert_allclose(found, np.sin(3.0 * x), atol=1e-4)
