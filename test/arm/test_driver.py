"""What a real driver makes of a run: each fault is in its report, as large as asked."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from lagrangian_ff.arm import (
    ArmParameters,
    Driver,
    Run,
    exciting_trajectory,
    fine,
    reported,
    simulate,
    true_torque,
)
from lagrangian_ff.recording import Recording

ARM = fine(ArmParameters(link_masses=(0.7, 1.3, 1.3, 1.2, 1.0, 1.3)))
PERFECT = Driver(rate=500.0)


@pytest.fixture(scope="module")
def run() -> Run:
    return simulate(exciting_trajectory(4, 1, duration=4.0), parameters=ARM)


def report(run: Run, **faults: Any) -> Recording:
    return reported(run, replace(PERFECT, **faults), ARM, seed=3)


def torque(run: Run) -> np.ndarray:
    """Return the torque at the instants of the positions: each was held for a tick before."""
    effort = run.recording.effort
    return 0.5 * (effort + np.concatenate([effort[1:], effort[-1:]]))


def test_a_perfect_driver_reports_what_the_sensors_see(run: Run) -> None:
    seen = report(run)
    np.testing.assert_allclose(seen.time, run.recording.time, atol=1e-9)
    np.testing.assert_allclose(seen.position, run.encoder, atol=1e-6)
    np.testing.assert_allclose(seen.effort, torque(run), atol=1e-9)
    assert np.sqrt(np.mean((seen.velocity - run.velocity) ** 2)) < 0.02


@pytest.mark.parametrize("rate", [90.0, 5000.0])
def test_it_reports_at_its_rate(run: Run, rate: float) -> None:
    seen = report(run, rate=rate)
    np.testing.assert_allclose(np.diff(seen.time), 1.0 / rate)
    assert seen.time[-1] == pytest.approx(run.recording.time[-1], abs=1.0 / rate)


def test_late_effort_is_that_of_an_earlier_position(run: Run) -> None:
    late, true = report(run, delay=0.008).effort, torque(run)
    np.testing.assert_allclose(late[4:], true[:-4], atol=1e-9)


def test_gains_and_rounding(run: Run) -> None:
    gains, steps = (1.1, 0.9, 1.0, 1.15, 0.85, 1.0), (0.5, 0.5, 0.2, 0.1, 0.0, 0.05)
    seen = report(run, gains=gains, effort_step=steps, position_step=1e-4)
    ideal = torque(run) * gains
    error = np.abs(seen.effort - ideal).max(axis=0)
    assert np.all(error <= 0.5 * np.array(steps) + 1e-9)
    assert len(np.unique(seen.effort[:, 0])) < 0.2 * len(seen)
    np.testing.assert_allclose(np.rint(seen.position / 1e-4) * 1e-4, seen.position, atol=1e-12)


def test_coloured_noise_has_its_size_and_its_memory(run: Run) -> None:
    noise = report(run, coloured=(1.0,) * 6, memory=0.02).effort - torque(run)
    assert noise.std() == pytest.approx(1.0, rel=0.15)
    kept = np.mean(noise[1:] * noise[:-1]) / np.mean(noise**2)
    assert kept == pytest.approx(np.exp(-0.1), abs=0.03)
    white = report(run, white=(1.0,) * 6).effort - torque(run)
    assert white.std() == pytest.approx(1.0, rel=0.05)
    assert abs(np.mean(white[1:] * white[:-1])) < 0.05


def test_lost_samples_keep_the_stamps_of_the_others(run: Run) -> None:
    seen, whole = report(run, lost=0.1, burst=5.0), report(run)
    assert 0.03 < 1.0 - len(seen) / len(whole) < 0.25
    rows = np.searchsorted(whole.time, seen.time - 1e-6)
    np.testing.assert_array_equal(seen.position, whole.position[rows])
    gaps = np.diff(rows)
    assert gaps[gaps > 1].mean() > 3.0


def test_stamps_are_late_and_in_order_and_the_samples_are_taken_evenly(run: Run) -> None:
    seen, whole = report(run, jitter=5e-4), report(run)
    np.testing.assert_array_equal(seen.position, whole.position)
    late = seen.time - whole.time
    assert np.ptp(late) > 1e-3
    assert np.all(np.diff(seen.time) > 0.0)


def test_without_gravity_it_takes_off_that_of_this_arm(run: Run) -> None:
    still = np.zeros_like(run.position)
    weight = true_torque(run.position, still, still, friction=False, parameters=ARM)
    taken = torque(run) - report(run, gravity=False).effort
    np.testing.assert_allclose(taken, weight, atol=0.05)
    usual = true_torque(run.position, still, still, friction=False)
    assert np.abs(taken - usual)[:, 1].max() > 1.0
