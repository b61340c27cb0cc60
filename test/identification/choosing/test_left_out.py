"""Errors on blocks left out: their mean log, and when one is surely less than another."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from lagrangian_ff.identification.choosing.left_out import mean_logs, surely_less, typical

FOLDS = arrays(np.float64, 5, elements=st.floats(-3.0, 3.0))


def test_the_mean_log_leaves_out_joints_that_were_not_solved() -> None:
    errors = np.array([[np.exp(-2.0), np.exp(-4.0)], [np.nan, np.exp(-1.0)], [np.nan, np.nan]])
    np.testing.assert_allclose(mean_logs(errors), [-3.0, -1.0, np.inf])


def test_the_typical_error_is_the_geometric_mean() -> None:
    assert typical(np.log([0.01, 0.04])) == pytest.approx(0.02)


@given(FOLDS, FOLDS)
def test_two_errors_are_not_each_surely_less_than_the_other(
    one: np.ndarray, two: np.ndarray
) -> None:
    assert not (surely_less(one, two) and surely_less(two, one))


@given(FOLDS, st.floats(0.01, 3.0))
def test_an_error_that_is_less_on_every_fold_alike_is_surely_less(
    one: np.ndarray, gain: float
) -> None:
    assert surely_less(one - gain, one)
    assert not surely_less(one, one)


def test_a_gain_by_chance_is_wrong_as_often_as_is_said() -> None:
    """A one-sided test at the 5 % level takes 1 in 20 pairs without a difference for one."""
    rng = np.random.default_rng(0)
    pairs = rng.normal(size=(4000, 2, 4))
    share = np.mean([surely_less(one, two) for one, two in pairs])
    assert share == pytest.approx(0.05, abs=3 * np.sqrt(0.05 * 0.95 / len(pairs)))


def test_nothing_is_sure_of_one_fold_or_without_a_factor() -> None:
    assert not surely_less(np.array([-5.0]), np.array([0.0]))
    without_factor, finite = np.full(3, np.inf), np.zeros(3)
    assert not surely_less(without_factor, finite)
    assert not surely_less(without_factor, without_factor)
    assert surely_less(finite, without_factor)
