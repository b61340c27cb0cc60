"""The bandwidth follows the noise of position and torque, on a motion whose physics is known."""

import re
import time

import numpy as np
import pytest

from lagrangian_ff.arrays import Floats
from lagrangian_ff.errors import RecordingError
from lagrangian_ff.recording import (
    Conditioning,
    Recording,
    condition,
    condition_alike,
    measured_bandwidth,
)

RATE = 400.0


def arm(
    *,
    position_noise: float = 0.0,
    torque_noise: float = 0.0,
    seconds: float = 30.0,
    rate: float = RATE,
    seed: int = 0,
) -> Recording:
    """Two joints with gravity, inertia and friction; noise of position in rad, of torque in N·m."""
    random = np.random.default_rng(seed)
    time = np.arange(round(seconds * rate)) / rate
    q, qd, qdd = np.zeros((3, len(time), 2))
    for frequency in np.arange(0.1, 1.2, 0.1):
        amplitude, phase = random.uniform(0.05, 0.2, 2), random.uniform(0.0, 2 * np.pi, 2)
        omega = 2 * np.pi * frequency * np.array([1.0, 1.1])
        angle = np.outer(time, omega) + phase
        q += amplitude * np.sin(angle)
        qd += amplitude * omega * np.cos(angle)
        qdd -= amplitude * omega**2 * np.sin(angle)
    tau = np.array([4.0, 1.0]) * qdd + np.array([3.0, 1.0]) * np.tanh(qd / 0.01)
    tau += np.array([20.0, 5.0]) * np.sin(q)
    tau += torque_noise * random.standard_normal(tau.shape)
    measured: Floats = q + position_noise * random.standard_normal(q.shape)
    return Recording(("base", "elbow"), time, measured, np.full(q.shape, np.nan), tau)


def hertz(recording: Recording) -> float:
    return measured_bandwidth([recording]).hertz


def test_clean_recordings_get_the_usual_bandwidth() -> None:
    found = measured_bandwidth([arm(position_noise=1e-6, torque_noise=0.05)])
    assert found.hertz == 25.0
    assert found.reason.startswith("bandwidth 25 Hz: the widest")


def test_noise_of_position_lowers_it_as_its_fourth_derivative_says() -> None:
    """Torque from noisy acceleration has the power B^5; a tenfold noise leaves 0.4 times B."""
    some, more = (arm(position_noise=noise) for noise in (3e-4, 3e-3))
    assert 4.0 < hertz(more) < hertz(some) < 25.0
    assert hertz(more) / hertz(some) == pytest.approx(10 ** (-2 / 5), rel=0.15)
    assert "noise of the acceleration" in measured_bandwidth([some]).reason


def test_noise_of_torque_lowers_it_and_is_said_to_be_unrelated() -> None:
    found = measured_bandwidth([arm(torque_noise=40.0)])
    assert found.hertz < 15.0
    assert "torque is unrelated to the motion" in found.reason


@pytest.mark.filterwarnings("error")
def test_what_is_unrelated_is_a_number_also_where_samples_are_few() -> None:
    found = measured_bandwidth([arm(torque_noise=5.0, rate=40.0, seconds=60.0)])
    assert re.search(r"above it \d+ % of elbow's torque is unrelated", found.reason)


def test_the_noise_that_passes_is_what_was_added() -> None:
    """White noise of torque: its density is sigma / sqrt(rate / 2)."""
    found = measured_bandwidth([arm(torque_noise=2.0)])
    middle = 0.5 * (found.edges[1:] + found.edges[:-1])
    level = found.noise[(middle > 5.0) & (middle < 20.0)].mean(axis=0)
    assert level == pytest.approx(2.0 / np.sqrt(RATE / 2.0), rel=0.25)


def test_the_motion_itself_always_passes() -> None:
    """Its own bandwidth is 1.1 Hz; acceleration is nothing but noise here."""
    assert 4.0 <= hertz(arm(position_noise=0.03)) <= 6.5


def test_a_hidden_ripple_is_no_noise() -> None:
    """Torque that falls with frequency may be physics: it does not lower the bandwidth."""
    recording = arm(position_noise=1e-6, torque_noise=0.05)
    ripple = 1.5 * np.sin(25.0 * recording.position)
    effort = recording.effort + ripple
    hidden = Recording(
        recording.joints, recording.time, recording.position, recording.velocity, effort
    )
    assert hertz(hidden) == 25.0


def test_recordings_that_belong_together_get_one_bandwidth_which_their_record_keeps() -> None:
    clean, noisy = arm(), arm(position_noise=1e-3, seed=1)
    together = condition_alike([clean, noisy])
    (chosen,) = {motion.conditioning["bandwidth"] for motion in together}
    assert isinstance(chosen, float)
    assert hertz(noisy) <= chosen < hertz(clean)
    for motion in together:
        assert any(note.startswith(f"bandwidth {chosen:g} Hz: ") for note in motion.notes)
    later = condition(clean, Conditioning.from_record(together[0].conditioning))
    assert later.conditioning == together[0].conditioning


def test_a_slow_recording_gets_a_quarter_of_its_rate() -> None:
    assert hertz(arm(rate=48.0)) == pytest.approx(12.0, rel=0.02)
    assert hertz(arm(rate=20.0)) == pytest.approx(5.0)


def test_a_short_recording_gets_the_usual_and_says_so() -> None:
    found = measured_bandwidth([arm(seconds=4.0, position_noise=1e-3)])
    assert found.hertz == 25.0
    assert "too short" in found.reason


def test_a_number_is_taken_as_it_is() -> None:
    motion = condition(arm(position_noise=1e-3), Conditioning(bandwidth=20.0))
    assert motion.conditioning["bandwidth"] == 20.0
    with pytest.raises(RecordingError, match="bandwidth is 0"):
        Conditioning(bandwidth=0.0)


def test_it_is_cheap() -> None:
    """A minute of two joints; generous, since machines differ and are busy."""
    recording = arm(seconds=60.0, rate=500.0)
    measured_bandwidth([recording])
    began = time.process_time()
    measured_bandwidth([recording])
    assert time.process_time() - began < 1.0
