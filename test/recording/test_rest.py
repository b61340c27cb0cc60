"""Rest is found where a joint stands still, and only there."""

import numpy as np
from numpy.typing import NDArray

from lagrangian_ff.recording.rest import at_rest

Floats = NDArray[np.float64]
RATE = 200.0


def dwelling() -> tuple[Floats, Floats]:
    """Return 12 s: a swing, 2 s of rest, a slow creep of 5 mrad/s, and time (M,) with it."""
    t = np.arange(0.0, 12.0, 1.0 / RATE)
    swing = 0.5 * np.sin(np.pi * np.minimum(t, 5.0) / 2.0)
    creep = 0.005 * np.maximum(t - 7.0, 0.0)
    return t, swing + creep


def test_a_dwell_is_rest_and_a_creep_is_not() -> None:
    t, q = dwelling()
    rest = at_rest(t, q[:, None], np.zeros(len(t), dtype=np.int64))[:, 0]
    assert rest[(t > 5.1) & (t < 6.9)].all()
    assert not rest[t > 7.2].any()


def test_a_reversal_is_no_rest() -> None:
    t = np.arange(0.0, 20.0, 1.0 / RATE)
    q = np.column_stack([0.3 * np.sin(t), 0.05 * np.sin(3.0 * t)])
    assert not at_rest(t, q, np.zeros(len(t), dtype=np.int64)).any()


def test_a_joint_that_begins_from_rest_has_to_slide_first() -> None:
    """Until then its gear holds friction from before the recording, and nobody knows how much."""
    t = np.arange(0.0, 4.0, 1.0 / RATE)
    q = np.column_stack([0.5 * (1.0 - np.cos(t)), 0.3 * np.sin(t), 0.01 * np.sin(20.0 * t)])
    whole, cut = np.zeros(len(t), dtype=np.int64), (t >= 3.1).astype(np.int64)
    rest = at_rest(t, q, whole)
    np.testing.assert_array_equal(rest[:, 0], q[:, 0] <= 5e-3)
    assert not rest[:, 1:].any()
    # The second part begins soon after a reversal, which it does not show.
    q[:, 0] = 0.5 * np.cos(t)
    rest = at_rest(t, q, cut)
    apart = np.abs(q[:, 0] - q[np.argmax(cut), 0])
    np.testing.assert_array_equal(rest[t >= 3.1, 0], (apart <= 5e-3)[t >= 3.1])
    assert not rest[:, 1:].any()


def test_noise_below_the_encoder_step_does_not_hide_rest() -> None:
    t, q = dwelling()
    noisy = q + 2e-5 * np.random.default_rng(0).normal(size=len(q))
    rest = at_rest(t, noisy[:, None], np.zeros(len(t), dtype=np.int64))[:, 0]
    assert rest[(t > 5.1) & (t < 6.9)].mean() > 0.95


def test_each_joint_rests_for_itself_and_a_gap_is_no_rest() -> None:
    t, q = dwelling()
    both = np.column_stack([q, np.sin(2.0 * t)])
    rest = at_rest(t, both, np.zeros(len(t), dtype=np.int64))
    assert rest[:, 0].any()
    assert not rest[:, 1].any()
    apart = np.repeat([0, 1], len(t) // 2)
    jump = np.where(apart == 1, 1.0, 0.0)[:, None] + np.zeros((len(t), 1))
    assert at_rest(t, jump, apart).all()
    assert not at_rest(np.full(len(t), np.inf), both, apart).any()
