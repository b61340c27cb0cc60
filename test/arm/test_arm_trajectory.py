"""Quintic trajectories: exactness, ends, and what they refuse."""

import numpy as np
import pytest
from arm_examples import move_to
from hypothesis import given, settings
from hypothesis import strategies as st

from lagrangian_ff.arm import HOME, JOINTS, Trajectory, check_limits, limits
from lagrangian_ff.errors import ArmError

TIMES = np.array([0.0, 0.7, 1.5, 3.0])


def quintic(seed: int) -> tuple[Trajectory, np.ndarray]:
    """Points of one polynomial of degree five in all, and its coefficients (6, 2)."""
    coefficients = np.random.default_rng(seed).normal(size=(6, 2))
    q, qd, qdd = polynomial(coefficients, TIMES)
    return Trajectory(TIMES, q, qd, qdd, ("a", "b")), coefficients


def polynomial(coefficients: np.ndarray, time: np.ndarray) -> list[np.ndarray]:
    values = []
    for order in range(3):
        curves = [np.polynomial.Polynomial(c) for c in coefficients.T]
        values.append(np.stack([c.deriv(order)(time) for c in curves], axis=1))
    return values


@settings(max_examples=30, deadline=None)
@given(seed=st.integers(0, 10_000), time=st.floats(0.0, 3.0))
def test_a_quintic_comes_back_exactly(seed: int, time: float) -> None:
    trajectory, coefficients = quintic(seed)
    for found, expected in zip(
        trajectory.sample(time), polynomial(coefficients, np.array([time])), strict=True
    ):
        np.testing.assert_allclose(found, expected[0], rtol=1e-9, atol=1e-8)


def test_velocity_and_acceleration_are_derivatives() -> None:
    random = np.random.default_rng(0)
    trajectory = Trajectory(TIMES, *random.normal(size=(3, 4, 6)))
    time, h = np.linspace(0.1, 2.9, 40), 1e-5
    q, qd, qdd = trajectory.sample(time)
    after, before = trajectory.sample(time + h), trajectory.sample(time - h)
    np.testing.assert_allclose((after[0] - before[0]) / (2 * h), qd, atol=1e-5)
    np.testing.assert_allclose((after[1] - before[1]) / (2 * h), qdd, atol=1e-3)
    assert q.shape == (40, 6)
    assert trajectory.sample(1.0)[0].shape == (6,)
    assert trajectory.sample(np.zeros((3, 2)))[0].shape == (3, 2, 6)


def test_points_are_met_and_outside_the_arm_rests() -> None:
    random = np.random.default_rng(1)
    trajectory = Trajectory(TIMES, *random.normal(size=(3, 4, 6)))
    for found, given_ in zip(
        trajectory.sample(TIMES), (trajectory.q, trajectory.qd, trajectory.qdd), strict=True
    ):
        np.testing.assert_allclose(found, given_, atol=1e-9)
    for instant, end in ((-0.5, 0), (3.5, -1)):
        q, qd, qdd = trajectory.sample(instant)
        np.testing.assert_allclose(q, trajectory.q[end], atol=1e-12)
        np.testing.assert_array_equal(qd, np.zeros(6))
        np.testing.assert_array_equal(qdd, np.zeros(6))


def test_a_trajectory_through_more_points_of_a_motion_is_that_motion() -> None:
    trajectory, _ = quintic(3)
    points = np.linspace(0, 3, 31)
    dense = Trajectory(points, *trajectory.sample(points), trajectory.joints)
    time = np.linspace(0, 3, 77)
    for found, expected in zip(dense.sample(time), trajectory.sample(time), strict=True):
        np.testing.assert_allclose(found, expected, atol=1e-8)


def test_one_point_is_a_pose() -> None:
    pose = Trajectory(np.zeros(1), np.ones((1, 6)), np.zeros((1, 6)), np.zeros((1, 6)))
    np.testing.assert_array_equal(pose.sample([0.0, 5.0])[0], np.ones((2, 6)))
    assert pose.duration == 0.0


def test_effort_is_linear_between_points_and_survives_selection() -> None:
    trajectory, _ = quintic(0)
    with pytest.raises(ArmError, match="carries no effort"):
        trajectory.effort_at(0.0)
    effort = np.array([[0.0, 1.0], [2.0, 1.0], [2.0, 5.0], [0.0, 0.0]])
    carrier = Trajectory(TIMES, trajectory.q, trajectory.qd, trajectory.qdd, ("a", "b"), effort)
    np.testing.assert_allclose(carrier.effort_at([0.35, 9.0]), [[1.0, 1.0], [0.0, 0.0]])
    np.testing.assert_array_equal(carrier.select(["b"]).effort_at(0.0), [1.0])
    with pytest.raises(ArmError, match=r"no joint c; it moves a, b"):
        carrier.select(["c"])


@settings(max_examples=25, deadline=None)
@given(shares=st.lists(st.floats(0.0, 1.0), min_size=6, max_size=6))
def test_a_quintic_between_two_points_goes_from_rest_to_rest(shares: list[float]) -> None:
    low, high, velocity, _ = limits()
    goal = low + np.array(shares) * (high - low)
    move = move_to(HOME, goal)
    q, qd, qdd = move.sample(np.linspace(0, move.duration, 101))
    np.testing.assert_allclose(q[[0, -1]], np.array([HOME, goal]), atol=1e-9)
    np.testing.assert_allclose(qd[[0, -1]], 0.0, atol=1e-9)
    np.testing.assert_allclose(qdd[[0, -1]], 0.0, atol=1e-9)
    assert np.all(np.abs(qd) <= 0.4 * velocity + 1e-9)
    assert np.all((q >= np.minimum(HOME, goal) - 1e-9) & (q <= np.maximum(HOME, goal) + 1e-9))
    check_limits(move)


def test_what_is_no_trajectory_is_refused() -> None:
    q = np.zeros((4, 6))
    with pytest.raises(ArmError, match=r"qd has shape \(3, 6\), expected \(4, 6\)"):
        Trajectory(TIMES, q, q[:3], q)
    with pytest.raises(ArmError, match=r"time does not increase at 0\.500 s"):
        Trajectory(np.array([0.0, 1.0, 0.5, 2.0]), q, q, q)
    with pytest.raises(ArmError, match="time"):
        Trajectory(np.array([0.0, 1.0, np.nan, 2.0]), q, q, q)
    with pytest.raises(ArmError, match="at least one point"):
        Trajectory(np.empty(0), np.empty((0, 6)), np.empty((0, 6)), np.empty((0, 6)))
    bad = q.copy()
    bad[2, 5] = np.inf
    with pytest.raises(ArmError, match=r"qdd of joint_6 at 1\.500 s"):
        Trajectory(TIMES, q, q, bad)
    assert len(JOINTS) == q.shape[1]
