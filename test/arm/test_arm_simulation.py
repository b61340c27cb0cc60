"""Closed-loop runs: the paper's three groups, the kinds of feedforward, and bad input."""

import numpy as np
import pytest
from arm_examples import move_to

from lagrangian_ff.arm import (
    HOME,
    JOINTS,
    Run,
    Trajectory,
    exciting_trajectory,
    simulate,
    true_torque,
)
from lagrangian_ff.errors import ArmError

GOAL = (0.8, 0.1, -0.3, 0.5, 0.3, -0.6)
MOVE = move_to(HOME, GOAL)


def without_friction(q: np.ndarray, qd: np.ndarray, qdd: np.ndarray) -> np.ndarray:
    return true_torque(q, qd, qdd, friction=False)


def error(run: Run) -> float:
    return float(np.sqrt(np.mean(run.tracking_error**2)))


def test_tracking_falls_in_the_papers_three_groups() -> None:
    trajectory = exciting_trajectory(6, duration=4.0)
    none = simulate(trajectory)
    partial = simulate(trajectory, without_friction)
    full = simulate(trajectory, "true")
    assert 0.01 < error(none) < 0.06
    assert error(partial) < 0.7 * error(none)
    assert error(full) < 0.2 * error(partial)
    assert not none.saturated.any()
    assert not full.saturated.any()
    # Feedforward replaces feedback, not torque: the motors give about the same in both.
    share = np.sqrt(np.mean((none.motor_torque - full.motor_torque) ** 2, axis=0))
    assert np.all(share < 0.5 * np.sqrt(np.mean(full.motor_torque**2, axis=0)))


def test_a_run_holds_what_was_measured_and_what_was_true() -> None:
    run = simulate(MOVE, "true", seed=2)
    count = round(MOVE.duration * 500) + 1
    assert run.recording.joints == JOINTS
    assert len(run.recording) == len(run.reference) == pytest.approx(count, abs=1)
    np.testing.assert_allclose(np.diff(run.recording.time), 0.002, atol=1e-12)
    np.testing.assert_allclose(run.recording.position, run.position, atol=5e-5)
    np.testing.assert_allclose(run.reference.q[0], HOME, atol=1e-12)
    np.testing.assert_allclose(run.tracking_error, run.reference.q - run.recording.position)
    middle = np.gradient(run.recording.position, 0.002, axis=0)[5:-5]
    np.testing.assert_allclose(middle, run.velocity[5:-5], atol=0.05)
    np.testing.assert_array_equal(
        run.recording.effort, simulate(MOVE, "true", seed=2).recording.effort
    )


def test_feedforward_may_be_a_function_an_array_or_the_trajectorys_own() -> None:
    time = np.append(np.arange(0.0, MOVE.duration, 0.01), MOVE.duration)
    dense = Trajectory(time, *MOVE.sample(time))
    points = true_torque(dense.q, dense.qd, dense.qdd)
    carrier = Trajectory(dense.time, dense.q, dense.qd, dense.qdd, effort=points)
    by_function = simulate(dense, true_torque)
    by_array = simulate(dense, points)
    by_trajectory = simulate(carrier, "trajectory")
    bound = simulate(dense, "true")
    np.testing.assert_array_equal(by_function.feedforward, bound.feedforward)
    np.testing.assert_array_equal(by_array.feedforward, by_trajectory.feedforward)
    np.testing.assert_allclose(by_array.feedforward[::5], points, atol=1e-9)
    assert error(by_array) < 2.0 * error(bound) + 1e-4


def test_loads_are_driven_by_their_own_true_torque() -> None:
    loads = {"joint_1": 10.0, "joint_2": 4.0}
    light = simulate(MOVE, true_torque, loads=loads)
    right = simulate(MOVE, "true", loads=loads)
    assert error(right) < 0.2 * error(light)


def test_joints_may_come_in_any_order() -> None:
    order = tuple(reversed(JOINTS))
    points = true_torque(MOVE.q, MOVE.qd, MOVE.qdd)
    turned = simulate(MOVE.select(order), points[:, ::-1])
    straight = simulate(MOVE, points)
    np.testing.assert_array_equal(turned.recording.position, straight.recording.position)


def test_progress_is_reported() -> None:
    seen: list[float] = []
    simulate(move_to(HOME, HOME), progress=lambda fraction, _: seen.append(fraction))
    assert seen == sorted(seen)
    assert seen[-1] == 1.0
    assert len(seen) > 10


def points(q: np.ndarray, joints: tuple[str, ...] = JOINTS) -> Trajectory:
    still = np.zeros_like(q)
    return Trajectory(np.arange(float(len(q))) * 3.0, q, still, still, joints)


def test_motions_the_arm_cannot_make_are_refused() -> None:
    far = np.array([HOME, HOME, HOME])
    far[1, 2] = 3.0
    with pytest.raises(ArmError, match=r"position of joint_3 at 1\.\d+ s is 1\.05"):
        simulate(points(far))
    fast = np.array([HOME, HOME])
    fast[1, 1] = 0.8
    hurried = Trajectory(np.array([0.0, 0.3]), fast, np.zeros_like(fast), np.zeros_like(fast))
    with pytest.raises(ArmError, match=r"velocity of joint_2 at 0\.\d+ s"):
        simulate(hurried)
    folded = np.array([HOME, (1.9, 1.2, 1.05, 0.16, 0.92, 1.9)])
    with pytest.raises(ArmError, match=r"base_link and link_6 touch at \d\.\d+ s"):
        simulate(points(folded))
    with pytest.raises(ArmError, match="no joint elbow"):
        simulate(points(np.array([HOME, HOME]), (*JOINTS[:5], "elbow")))
    with pytest.raises(ArmError, match="no joint joint_6"):
        simulate(points(np.array([HOME, HOME])[:, :5], JOINTS[:5]))


def test_feedforward_that_does_not_fit_is_refused() -> None:
    with pytest.raises(ArmError, match="one row for each point"):
        simulate(MOVE, np.zeros((5, 6)))
    with pytest.raises(ArmError, match="carries no effort"):
        simulate(MOVE, "trajectory")
    with pytest.raises(ArmError, match="'perfect'"):
        simulate(MOVE, "perfect")  # type: ignore[arg-type]
    with pytest.raises(ArmError, match="function gave"):
        simulate(MOVE, lambda q, qd, qdd: q[:, :3])

    def broken(q: np.ndarray, qd: np.ndarray, qdd: np.ndarray) -> np.ndarray:
        torque = np.zeros_like(q)
        torque[50, 4] = np.nan
        return torque

    with pytest.raises(ArmError, match=r"torque of joint_5 at 0\.100 s"):
        simulate(MOVE, broken)
