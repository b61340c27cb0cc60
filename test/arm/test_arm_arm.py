"""The arm as a stepped device."""

from collections.abc import Iterator

import numpy as np
import pytest

from lagrangian_ff.arm import HOME, Arm, limits
from lagrangian_ff.errors import ArmError

STILL = np.zeros(6)


@pytest.fixture
def arm() -> Iterator[Arm]:
    it = Arm()
    yield it
    it.close()


def drive(arm: Arm, ticks: int = 60) -> np.ndarray:
    arm.reset(np.array(HOME))
    reference = np.array(HOME) + 0.05
    samples = [arm.step(reference, STILL) for _ in range(ticks)]
    return np.array([np.concatenate([[s.time], *s[1:]]) for s in samples])


def test_the_same_seed_gives_the_same_samples_to_the_last_bit() -> None:
    first, second, other = Arm(seed=4), Arm(seed=4), Arm(seed=5)
    a, b, c = drive(first), drive(second), drive(other)
    np.testing.assert_array_equal(a, b)
    np.testing.assert_array_equal(a, drive(first))
    assert not np.array_equal(a, c)
    for it in (first, second, other):
        it.close()


def test_samples_come_at_500_hz_and_describe_the_beginning_of_the_tick(arm: Arm) -> None:
    samples = drive(arm, 20)
    np.testing.assert_allclose(np.diff(samples[:, 0]), 0.002, atol=1e-12)
    assert samples[0, 0] == 0.0
    np.testing.assert_allclose(samples[0, 1:7], HOME, atol=3e-5)
    assert arm.time == pytest.approx(0.04)


def test_the_servo_pulls_the_arm_to_its_reference(arm: Arm) -> None:
    home = np.array(HOME)
    arm.reset(home)
    hold = arm.plant.true_torque(home + 0.05, STILL, STILL)
    for _ in range(1000):
        sample = arm.step(home + 0.05, STILL, hold)
    np.testing.assert_allclose(sample.position, home + 0.05, atol=2e-3)


def test_measured_effort_is_the_motors_torque(arm: Arm) -> None:
    home = np.array(HOME)
    arm.reset(home)
    hold = arm.plant.true_torque(home, STILL, STILL)
    efforts, given = [], []
    for _ in range(600):
        efforts.append(arm.step(home, STILL, hold).effort)
        given.append(arm.torques[0])
    error = np.mean(efforts[100:], axis=0) - np.mean(given[100:], axis=0)
    np.testing.assert_allclose(error, 0.0, atol=0.12)
    np.testing.assert_allclose(np.mean(given[100:], axis=0), hold, atol=0.05)


def test_torque_is_cut_at_the_limits_and_flagged(arm: Arm) -> None:
    effort = limits().effort
    asked = np.zeros(6)
    asked[[1, 4]] = 10.0 * effort[[1, 4]] * (-1, 1)
    for _ in range(5):
        arm.step(np.array(HOME), STILL, asked)
    np.testing.assert_array_equal(arm.saturated, asked != 0)
    # The current lags a little while the arm races away and its back-EMF grows.
    np.testing.assert_allclose(arm.torques[0][[1, 4]], effort[[1, 4]] * (-1, 1), rtol=0.15)
    assert np.all(np.abs(arm.torques[0]) < effort)


@pytest.mark.parametrize("what", ["reference position", "reference velocity", "feedforward torque"])
@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_bad_numbers_are_refused_by_joint_and_time_and_nothing_moves(
    arm: Arm, what: str, value: float
) -> None:
    arm.step(np.array(HOME), STILL)
    before = arm.plant.q.copy()
    inputs = {
        "reference position": np.array(HOME),
        "reference velocity": np.zeros(6),
        "feedforward torque": np.zeros(6),
    }
    inputs[what][3] = value
    with pytest.raises(ArmError, match=rf"{what} of joint_4 at 0\.002 s"):
        arm.step(*inputs.values())
    np.testing.assert_array_equal(arm.plant.q, before)
    assert arm.time == pytest.approx(0.002)


def test_another_number_of_joints_is_refused(arm: Arm) -> None:
    with pytest.raises(ArmError, match="expected 6 values"):
        arm.step(np.zeros(5), STILL)


def test_a_start_outside_the_limits_is_refused(arm: Arm) -> None:
    with pytest.raises(ArmError, match=r"joint_3 is 9\.0000 rad, outside"):
        arm.reset(np.array([0, 0, 9.0, 0, 0, 0]))
