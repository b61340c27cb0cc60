"""Falsified sensors: late, clipped, off the axis; and that none of it moves the arm by itself."""

import numpy as np
import pytest

from lagrangian_ff.arm import exciting_trajectory, simulate
from lagrangian_ff.arm.hidden.sensing import ClippedEffort, LateEffort, OffAxis

MOTION = exciting_trajectory(6, 1, duration=4.0)


@pytest.mark.parametrize("delay", [0.0, 0.002, 0.005, 0.0123])
def test_effort_comes_late_by_the_delay(delay: float) -> None:
    sensor = LateEffort(2, delay)
    time = 0.002 * np.arange(200)
    effort = np.tile(np.sin(20.0 * time)[:, None], (1, 6))
    for _ in range(2):
        sensor.reset()
        seen = np.array(
            [sensor.sense(t, np.zeros(6), row)[1] for t, row in zip(time, effort, strict=True)]
        )
        late = np.where(time >= delay, np.interp(time - delay, time, effort[:, 2]), 0.0)
        np.testing.assert_allclose(seen[:, 2], late, atol=1e-9)
        np.testing.assert_array_equal(np.delete(seen, 2, axis=1), np.delete(effort, 2, axis=1))


def test_a_sensor_of_effort_does_not_move_the_arm() -> None:
    true = simulate(MOTION)
    for sensor in (LateEffort(1, 0.01), ClippedEffort(1, 15.0)):
        run = simulate(MOTION, sensors=[sensor])
        np.testing.assert_array_equal(run.position, true.position)
        assert not np.array_equal(run.recording.effort, true.recording.effort)
        others = [0, 2, 3, 4, 5]
        np.testing.assert_allclose(
            run.recording.effort[:, others], true.recording.effort[:, others], atol=1e-12
        )


def test_clipping_leaves_only_noise_above_the_limit() -> None:
    run = simulate(MOTION, sensors=[ClippedEffort(1, 15.0)])
    noise = 160.0 * 0.0385 * 0.12
    assert np.abs(run.motor_torque[:, 1]).max() > 20.0
    assert np.abs(run.recording.effort[:, 1]).max() < 15.0 + 6.0 * noise


def test_an_encoder_off_its_axis_errs_once_a_turn() -> None:
    run = simulate(MOTION, sensors=[OffAxis(0, 0.01, 0.3)])
    error = run.recording.position[:, 0] - run.position[:, 0]
    np.testing.assert_allclose(error, 0.01 * np.cos(run.position[:, 0] + 0.3), atol=3e-5)
    # The servo believes its encoder: the arm is off by what it cannot see.
    assert np.abs(run.tracking_error[:, 0]).max() < 0.06
