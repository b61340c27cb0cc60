"""Order, repeats, periods and resets of time stamps."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from lagrangian_ff.recording.stamps import clock_resets, order, usual_period, without_resets

CLEAN = 0.002 * np.arange(200, dtype=np.float64)


@given(st.permutations(range(40)), st.lists(st.integers(0, 39), max_size=10))
def test_order_recovers_a_shuffled_and_repeated_clock(
    shuffle: list[int], repeats: list[int]
) -> None:
    time = CLEAN[np.array([*shuffle, *repeats])]
    found = order(time)
    assert np.array_equal(time[found.index], CLEAN[:40])
    assert found.repeated == len(repeats)
    assert found.period == pytest.approx(0.002)
    # The first to arrive of equal stamps is kept.
    assert found.index.max() < 40


def test_samples_that_came_late_are_counted() -> None:
    time = CLEAN.copy()
    time[[10, 11]] = time[[11, 10]]
    assert order(time).moved == 1
    assert order(CLEAN).moved == 0


def test_stamps_almost_equal_are_one_sample() -> None:
    found = order(np.array([0.0, 0.002, 0.0020001, 0.004, 0.006]))
    assert list(found.index) == [0, 1, 3, 4]
    assert found.repeated == 1


@given(st.lists(st.integers(1, 198), min_size=1, max_size=60, unique=True))
def test_lost_samples_do_not_bias_the_period(lost: list[int]) -> None:
    assert usual_period(np.diff(np.delete(CLEAN, lost))) == pytest.approx(0.002, rel=0.5)


def test_jitter_does_not_bias_the_period() -> None:
    jitter = np.random.default_rng(0).uniform(-2e-4, 2e-4, CLEAN.size)
    assert usual_period(np.diff(CLEAN + jitter)) == pytest.approx(0.002, rel=0.01)


def test_few_samples_have_no_period_and_no_error() -> None:
    for time in (np.empty(0), np.array([1.0]), np.array([1.0, 1.0])):
        found = order(time)
        assert np.isnan(found.period)
        assert len(found.index) == min(1, len(time))


def test_a_clock_set_back_is_told_from_disorder() -> None:
    twice = np.concatenate([10 + CLEAN, 5 + CLEAN])
    assert list(clock_resets(twice)) == [200]
    assert clock_resets(np.random.default_rng(0).permutation(100 * CLEAN)).size == 0
    late = 100 * CLEAN
    late[[50, 150]] = late[[150, 50]]
    assert clock_resets(late).size == 0


def test_what_follows_a_reset_is_moved_behind() -> None:
    time, resets = without_resets(np.concatenate([10 + CLEAN, 5 + CLEAN]))
    assert list(resets) == [200]
    assert (np.diff(time) > 0).all()
    assert time[200] - time[199] == pytest.approx(1.0)
    assert np.allclose(np.diff(time[200:]), 0.002)
