"""When a joint turns round."""

from dataclasses import replace

import numpy as np
from where_examples import motion, single

from lagrangian_ff.diagnosis.where.reversals import before_reversal, direction, since_reversal
from lagrangian_ff.recording.motion import Motion


def swing(seconds: float = 4.0, noise: float = 0.0) -> Motion:
    """A joint that turns round at every half second past a full one."""
    t = np.arange(0.0, seconds, 0.001)
    qd = np.cos(np.pi * t) + noise * np.random.default_rng(0).normal(size=len(t))
    return single(t, np.sin(np.pi * t) / np.pi, qd, 0.0 * qd)


def test_time_since_and_until_a_reversal_of_a_sine() -> None:
    moved = swing()
    t = moved.time
    later, earlier = t > 0.51, t < 3.49
    since, before = since_reversal(moved, 0), before_reversal(moved, 0)
    assert np.isnan(since[t < 0.49]).all()
    assert np.isnan(before[t > 3.51]).all()
    after, until = (t - 0.5) % 1.0, (0.5 - t) % 1.0
    away = np.minimum(after, until) > 5e-3  # at a reversal itself both are right
    np.testing.assert_allclose(since[later & away], after[later & away], atol=2e-3)
    np.testing.assert_allclose(before[earlier & away], until[earlier & away], atol=2e-3)


def test_noise_about_zero_is_no_reversal() -> None:
    moved = swing(noise=0.001)
    turns = np.flatnonzero(np.diff(direction(moved, 0)))
    assert len(turns) == 4


def test_a_joint_that_rests_keeps_its_direction() -> None:
    moved = swing()
    qd = np.where(moved.time[:, None] < 0.4, moved.qd, 1e-4 * (-1.0) ** np.arange(4000)[:, None])
    np.testing.assert_array_equal(direction(replace(moved, qd=qd), 0), 1.0)


def test_a_joint_that_never_moves_has_no_direction() -> None:
    moved = swing()
    still = replace(moved, qd=0.0 * moved.qd)
    assert np.isnan(direction(still, 0)).all()
    assert np.isnan(since_reversal(still, 0)).all()


def test_nothing_is_known_across_an_interruption() -> None:
    moved = motion(1)
    half = len(moved) // 2
    parts = [moved.take(slice(None, half)), moved.take(slice(half, None))]
    cut = replace(moved, segment=(np.arange(len(moved)) >= half).astype(np.int64))
    for found in (since_reversal, before_reversal):
        expected = np.concatenate([found(part, 0) for part in parts])
        np.testing.assert_allclose(found(cut, 0), expected)
