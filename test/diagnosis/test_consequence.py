"""An effect is judged by the error where its joint moves, and by that of all joints."""

from dataclasses import replace

import numpy as np
import pendulum
from diagnosis_examples import JOINTS, model
from numpy.typing import NDArray

from lagrangian_ff.diagnosis.consequence import BLOCK_SECONDS, consequence_of, errors_of
from lagrangian_ff.recording.motion import Motion

Floats = NDArray[np.float64]


def half_held() -> Motion:
    """Return a motion whose elbow stands still in its second half."""
    motion = pendulum.motion(18.0)
    q, half = motion.q.copy(), len(motion) // 2
    q[half:, 1] = q[half, 1]
    return replace(motion, q=q)


def residual(elbow: float, held: float) -> Floats:
    """Return (M, 2) N·m: errors of both joints while they move, and of the elbow while held."""
    motion = half_held()
    rng = np.random.default_rng(0)
    out = rng.normal(size=(len(motion), 2)) * np.array([0.1, elbow])
    out[len(motion) // 2 :, 1] = held
    rests = motion.rest
    return np.where(rests & ~rests.all(axis=0), np.nan, out)


def test_what_a_held_joint_shows_counts_for_nothing() -> None:
    motion, before = half_held(), residual(0.3, 1.0)
    made = consequence_of(model(), motion, JOINTS[1], before, residual(0.2, 5.0))
    assert made.worth
    assert made.whole_before == np.float64(np.sqrt(np.nanmean(before[:, 1] ** 2)))
    assert made.time.max() < 9.0 + BLOCK_SECONDS
    assert len(made.time) == len(made.before) == len(made.after)
    assert not consequence_of(model(), motion, JOINTS[1], before, residual(0.4, 0.0)).worth


def test_errors_are_missing_where_a_joint_rests_that_moves_elsewhere() -> None:
    motion = half_held()
    left = errors_of(model(), motion)
    np.testing.assert_array_equal(np.isnan(left), motion.rest)
    assert 0.4 < motion.rest[:, 1].mean() < 0.6
    still = replace(motion, q=np.zeros_like(motion.q))
    assert np.isfinite(errors_of(model(), still)).all()
