"""The mean residual over a coordinate and its band."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from where_examples import motion, noise, series

from lagrangian_ff.diagnosis.where import COORDINATES, bins_of

VELOCITY = COORDINATES["velocity"]


@settings(max_examples=20)
@given(st.integers(0, 100), st.sampled_from(sorted(COORDINATES)), st.integers(2, 20))
def test_the_bins_share_out_time_and_error(seed: int, name: str, count: int) -> None:
    moved = motion(seed, 20.0)
    looked = series(moved, noise(len(moved), seed))
    found = bins_of(looked, 0, COORDINATES[name], count)
    if found is None:
        assert name in ("outside_range", "rest")  # this motion never leaves the range or rests
        return
    values = COORDINATES[name].values(looked, 0)
    known = np.isfinite(values)
    assert found.share_of_time.sum() == pytest.approx(known.mean())
    squared = looked.residual[:, 0] ** 2
    assert found.share_of_error.sum() == pytest.approx(squared[known].sum() / squared.sum())
    if not COORDINATES[name].levels:
        assert np.ptp(found.share_of_time) < 0.03  # values may repeat
    assert np.all(found.mean_low <= found.mean_high)
    assert np.all(np.abs(found.mean) <= found.rms + 1e-12)


def test_the_mean_is_that_of_the_samples_inside() -> None:
    moved = motion()
    looked = series(moved, noise(len(moved), 1))
    found = bins_of(looked, 0, VELOCITY)
    assert found is not None
    qd, r = moved.qd[:, 0], looked.residual[:, 0]
    inside = (qd >= found.low[3]) & (qd < found.high[3])
    assert found.mean[3] == pytest.approx(r[inside].mean())
    assert found.rms[3] == pytest.approx(np.sqrt(np.mean(r[inside] ** 2)))


def test_the_band_holds_the_true_mean_nine_times_of_ten() -> None:
    held, total = 0, 0
    for seed in range(15):
        moved = motion(seed)
        truth = 0.5 * moved.qd[:, 0]
        found = bins_of(series(moved, truth + noise(len(moved), seed)), 0, VELOCITY)
        exact = bins_of(series(moved, truth), 0, VELOCITY)
        assert found is not None
        assert exact is not None
        held += int(np.sum((found.mean_low <= exact.mean) & (exact.mean <= found.mean_high)))
        total += len(found.mean)
    assert 0.8 <= held / total <= 0.98


def test_a_function_of_the_coordinate_is_explained_by_it() -> None:
    moved = motion()
    smooth = np.tanh(moved.qd[:, 0])
    explained = {
        name: found.explained
        for name in ("velocity", "position", "time")
        if (found := bins_of(series(moved, smooth), 0, COORDINATES[name], 40)) is not None
    }
    assert explained["velocity"] > 0.98
    assert explained["time"] < 0.5


def test_noise_is_explained_by_nothing() -> None:
    moved = motion()
    looked = series(moved, noise(len(moved), 3))
    for coordinate in COORDINATES.values():
        found = bins_of(looked, 0, coordinate)
        assert found is None or found.explained < 0.06


def test_a_joint_that_stands_still_has_no_bins_over_its_velocity() -> None:
    moved = motion()
    still = replace(moved, qd=0.0 * moved.qd)
    assert bins_of(series(still, noise(len(moved), 0)), 0, VELOCITY) is None


def test_the_two_directions_are_two_bins() -> None:
    moved = motion()
    found = bins_of(series(moved, np.sign(moved.qd[:, 0])), 0, COORDINATES["direction"])
    assert found is not None
    np.testing.assert_array_equal(found.low, [-1.0, 1.0])
    np.testing.assert_allclose(found.mean, [-1.0, 1.0], atol=0.01)


@pytest.mark.parametrize("name", ["velocity", "speed", "position", "acceleration"])
@pytest.mark.parametrize(("low", "high"), [(0.01, 1.0), (0.0, 0.99), (0.02, 0.99), (0.4, 0.6)])
def test_every_interval_has_a_place(name: str, low: float, high: float) -> None:
    assert COORDINATES[name].words(low, high, 0.0, 1.0)
