"""When a joint turns round."""

from dataclasses import replace

import numpy as np
import pytest
from effect_examples import motion

from lagrangian_ff.effects import Inputs
from lagrangian_ff.effects.reversals import before_reversal, direction, since_reversal
from lagrangian_ff.kernels import States

TIME = np.arange(0.0, 4.0, 0.001)
SPEED = np.cos(np.pi * TIME)
"""Of a joint that turns round at every half second past a full one."""
ONE = np.zeros(len(TIME), dtype=np.int64)


def test_time_since_and_until_a_reversal_of_a_sine() -> None:
    later, earlier = TIME > 0.51, TIME < 3.49
    since, before = since_reversal(TIME, SPEED, ONE), before_reversal(TIME, SPEED, ONE)
    assert np.isnan(since[TIME < 0.49]).all()
    assert np.isnan(before[TIME > 3.51]).all()
    after, until = (TIME - 0.5) % 1.0, (0.5 - TIME) % 1.0
    away = np.minimum(after, until) > 5e-3  # at a reversal itself both are right
    np.testing.assert_allclose(since[later & away], after[later & away], atol=2e-3)
    np.testing.assert_allclose(before[earlier & away], until[earlier & away], atol=2e-3)


def test_noise_about_zero_is_no_reversal() -> None:
    noise = 0.001 * np.random.default_rng(0).normal(size=len(TIME))
    assert len(np.flatnonzero(np.diff(direction(SPEED + noise, ONE)))) == 4


def test_a_joint_that_rests_keeps_its_direction() -> None:
    jitter = 1e-4 * (-1.0) ** np.arange(len(TIME))
    np.testing.assert_array_equal(direction(np.where(TIME < 0.4, SPEED, jitter), ONE), 1.0)


def test_a_joint_that_never_moves_has_no_direction() -> None:
    assert np.isnan(direction(0.0 * SPEED, ONE)).all()
    assert np.isnan(since_reversal(TIME, 0.0 * SPEED, ONE)).all()


def test_nothing_is_known_across_an_interruption() -> None:
    x = motion()
    speed, half = x.qd[:, 0], len(x) // 2
    cut = (np.arange(len(x)) >= half).astype(np.int64)
    for found in (since_reversal, before_reversal):
        parts = (slice(None, half), slice(half, None))
        expected = [found(x.time[one], speed[one], x.segment[one]) for one in parts]
        np.testing.assert_allclose(found(x.time, speed, cut), np.concatenate(expected))


def test_inputs_count_from_the_beginning_until_the_first_reversal() -> None:
    """And the samples that are taken from a motion know what came before them."""
    states = States.of(*(SPEED[:, None] * one for one in (0.0, 1.0, 0.0)))
    x = Inputs.of(states, time=TIME)
    since = x.since_reversal(0)
    np.testing.assert_allclose(since[TIME < 0.49], TIME[TIME < 0.49])
    later = TIME > 0.51
    np.testing.assert_array_equal(since[later], since_reversal(TIME, SPEED, ONE)[later])
    some = np.arange(0, len(x), 70)
    np.testing.assert_array_equal(x.take(some).since_reversal(0), since[some])
    long_ago = replace(x, time=np.full(len(x), np.inf)).since_reversal(0)
    assert long_ago == pytest.approx(10.0)


def test_inputs_know_the_slowest_reversal() -> None:
    short = np.flatnonzero(np.abs(TIME - 2.0) < 0.1)
    speed = SPEED.copy()
    speed[short] = -1e-3
    states = States.of(*(speed[:, None] * one for one in (0.0, 1.0, 0.0)))
    since = Inputs.of(states, time=TIME).since_reversal(0)
    np.testing.assert_allclose(since[short], TIME[short] - TIME[short[0]])
    assert since_reversal(TIME, speed, ONE)[short].min() > 0.3  # noise, for all that is known
