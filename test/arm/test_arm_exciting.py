"""Exciting trajectories: smooth, within limits, clear of everything, at ten speeds."""

import numpy as np
import pytest

from lagrangian_ff.arm import (
    HOME,
    PAPER_LOADS,
    Trajectory,
    exciting_trajectory,
    limits,
    true_torque,
)
from lagrangian_ff.arm.body import Surroundings
from lagrangian_ff.errors import ArmError


def mean_norm(trajectory: Trajectory) -> float:
    return float(np.linalg.norm(trajectory.qd, axis=1).mean())


def test_mean_velocity_rises_over_the_ten_speeds() -> None:
    motions = [exciting_trajectory(speed) for speed in range(1, 11)]
    norms = [mean_norm(motion) for motion in motions]
    assert np.all(np.diff(norms) > 0.2)
    assert norms[-1] > 7 * norms[0]
    assert all(29.9 <= motion.duration <= 40.1 for motion in motions)


@pytest.fixture(scope="module", params=[(1, 0), (6, 3), (10, 1)])
def motion(request: pytest.FixtureRequest) -> Trajectory:
    return exciting_trajectory(*request.param)


def test_it_stays_within_position_velocity_and_torque(motion: Trajectory) -> None:
    low, high, velocity, effort = limits()
    q, qd, qdd = motion.sample(np.arange(0, motion.duration, 0.0073))
    assert np.all((q > low) & (q < high))
    assert np.all(np.abs(qd) < velocity)
    for loads in (None, PAPER_LOADS):
        assert np.all(np.abs(true_torque(q, qd, qdd, loads=loads)) < effort)


def test_it_touches_neither_itself_nor_the_floor(motion: Trajectory) -> None:
    q, _, _ = motion.sample(np.arange(0, motion.duration, 0.031))
    with Surroundings(PAPER_LOADS) as surroundings:
        assert [surroundings.first_contact(row) for row in q] == [None] * len(q)


def test_it_begins_and_ends_at_home_at_rest(motion: Trajectory) -> None:
    np.testing.assert_allclose(motion.q[[0, -1]], [HOME, HOME], atol=1e-9)
    np.testing.assert_allclose(motion.qd[[0, -1]], 0.0, atol=1e-9)
    np.testing.assert_allclose(motion.qdd[[0, -1]], 0.0, atol=1e-8)


def test_it_is_smooth_to_the_jerk(motion: Trajectory) -> None:
    """Jerk at a point, from the quintic before and after it: a C⁴ spline has no step there."""
    h = 1e-3 * (motion.time[1] - motion.time[0])
    inner = motion.time[1:-1]
    at = motion.qdd[1:-1]
    after = (motion.sample(inner + h)[2] - at) / h
    before = (at - motion.sample(inner - h)[2]) / h
    largest = np.abs(after).max()
    assert np.abs(after - before).max() < 0.01 * largest


def test_it_visits_most_of_every_joints_range() -> None:
    low, high, _, _ = limits()
    for speed in (5, 9):
        q = exciting_trajectory(speed, seed=2).q
        assert np.all(np.ptp(q, axis=0) > 0.6 * (high - low))


def test_it_follows_from_its_seed_speed_and_duration() -> None:
    first, again, other = (exciting_trajectory(3, seed, 8.0) for seed in (7, 7, 8))
    np.testing.assert_array_equal(first.q, again.q)
    assert not np.array_equal(first.q[:500], other.q[:500])
    assert exciting_trajectory(3, duration=12.0).duration == pytest.approx(12.0)


@pytest.mark.parametrize(
    ("speed", "duration", "words"),
    [
        (0, None, "from 1 to 10, got 0"),
        (11, None, "from 1 to 10, got 11"),
        (5.0, None, "whole number from 1 to 10, got 5.0"),
        (5, 1.0, "at least 4 s"),
        (5, float("nan"), "at least 4 s"),
    ],
)
def test_impossible_requests_are_refused(speed: int, duration: float, words: str) -> None:
    with pytest.raises(ArmError, match=words):
        exciting_trajectory(speed, duration=duration)


def test_a_negative_seed_is_refused() -> None:
    with pytest.raises(ArmError, match=r"seed: expected a whole number from 0 up, got -1"):
        exciting_trajectory(5, seed=-1)
