"""An effect is judged by the error where its joint moves, and by that of all joints."""

from dataclasses import replace

import numpy as np
import pendulum
import pytest
from diagnosis_examples import JOINTS, model
from numpy.typing import NDArray

from lagrangian_ff.diagnosis.consequence import BLOCK_SECONDS, SURELY, consequence_of, errors_of
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
    made = consequence_of(model(), motion, [JOINTS[1]], before, residual(0.2, 5.0))
    assert made.worth
    assert made.whole_before == np.float64(np.sqrt(np.nanmean(before[:, 1] ** 2)))
    assert made.time.max() < 9.0 + BLOCK_SECONDS
    assert len(made.time) == len(made.before) == len(made.after)
    more = consequence_of(model(), motion, [JOINTS[1]], before, residual(0.4, 0.0))
    assert more.harms
    assert not made.harms
    assert not more.worth


def test_a_fall_that_is_not_sure_is_neither_worth_it_nor_harm() -> None:
    """The error falls much in one block, and rises in others."""
    motion = pendulum.motion(18.0)
    before = np.random.default_rng(0).normal(size=(len(motion), 2))
    first = motion.blocks(BLOCK_SECONDS) == 0
    before[first] *= 3.0
    after = before * np.where(first, 0.6, 1.1)[:, None]
    made = consequence_of(model(), motion, [JOINTS[1]], before, after)
    assert made.whole_after < made.whole_before
    assert not made.worth
    assert not made.harms


@pytest.mark.parametrize(("rise", "worth"), [("by chance", True), ("in every block", False)])
def test_another_joint_may_err_more_by_chance_alone(rise: str, worth: bool) -> None:
    motion = pendulum.motion(30.0)
    rng = np.random.default_rng(1)
    before = rng.normal(size=(len(motion), 2)) * np.array([0.5, 0.1])
    block = motion.blocks(BLOCK_SECONDS)
    sign = np.where(block % 2 == 0, 1.0, -0.8) if rise == "by chance" else np.ones(len(block))
    after = before * np.stack([1.0 + 0.03 * sign, np.full(len(motion), 0.95)], axis=1)
    made = consequence_of(model(), motion, [JOINTS[1]], before, after)
    assert made.every_after > made.every_before
    assert made.worth == worth


@pytest.mark.parametrize(("often", "worth"), [(0.65, True), (0.75, False)])
def test_a_refit_may_move_the_error_of_the_largest_joint(often: float, worth: bool) -> None:
    """By up to two deviations in N·m, where the joint in question halves its error."""
    motion = pendulum.motion(60.0)
    before = np.random.default_rng(1).normal(size=(len(motion), 2)) * np.array([0.5, 0.02])
    block = motion.blocks(BLOCK_SECONDS)
    higher = np.random.default_rng(2).permutation(np.arange(block.max() + 1) % 20 < 20 * often)
    sign = np.where(higher[block], 1.0, -1.0)
    after = before * np.stack([1.0 + 0.03 * sign, np.full(len(motion), 0.5)], axis=1)
    made = consequence_of(model(), motion, [JOINTS[1]], before, after)
    assert made.rise < 0.0
    assert made.rise_in_torque > 1.0
    assert (made.rise_in_torque < SURELY) == worth
    assert made.worth == worth
    assert made.harms != worth


@pytest.mark.parametrize(("small", "worth"), [(0.114, True), (0.3, False)])
def test_a_small_joint_counts_as_much_as_a_large_one(small: float, worth: bool) -> None:
    motion = pendulum.motion(30.0)
    one = np.random.default_rng(1).normal(size=(len(motion), 2))
    before, after = one * np.array([1.0, 0.1]), one * np.array([0.5, small])
    made = consequence_of(model(), motion, [JOINTS[0]], before, after)
    assert made.every_after < made.every_before
    assert made.worth == worth


@pytest.mark.parametrize(("small", "worth"), [(0.05, True), (0.103, False)])
def test_an_effect_of_two_joints_is_judged_by_both(small: float, worth: bool) -> None:
    """The joint that it was found on may show none of it, where another torque is larger."""
    motion = pendulum.motion(30.0)
    one = np.random.default_rng(1).normal(size=(len(motion), 2))
    before, after = one * np.array([1.0, 0.1]), one * np.array([1.0, small])
    made = consequence_of(model(), motion, JOINTS, before, after)
    assert made.worth == worth
    assert made.joint == JOINTS[1]
    assert made.whole_before == pytest.approx(0.1, rel=0.05)
    assert made.fall == pytest.approx(0.5 - 50.0 * small**2)
    assert not consequence_of(model(), motion, JOINTS[:1], before, after).worth


def test_errors_are_missing_where_a_joint_rests_that_moves_elsewhere() -> None:
    motion = half_held()
    left = errors_of(model(), motion)
    np.testing.assert_array_equal(np.isnan(left), motion.rest)
    assert 0.4 < motion.rest[:, 1].mean() < 0.6
    still = replace(motion, q=np.zeros_like(motion.q))
    assert np.isfinite(errors_of(model(), still)).all()
