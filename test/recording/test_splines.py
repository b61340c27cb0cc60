"""Splines, held against those of SciPy."""

import numpy as np
import pytest
from scipy.interpolate import CubicSpline, make_lsq_spline

from lagrangian_ff.recording.splines import interpolate, slopes, smooth

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
def test_the_nearest_spline_is_that_of_scipy(pieces: int) -> None:
    x = times(400)
    values = np.sin(3.0 * x / x[-1]) + 0.1 * RNG.normal(size=400)
    inner = np.linspace(x[0], x[-1], pieces + 1)[1:-1]
    knots = np.concatenate([[x[0]] * 4, inner, [x[-1]] * 4])
    np.testing.assert_allclose(
        smooth(x, values, pieces), make_lsq_spline(x, values, knots, k=3)(x), atol=1e-11
    )
