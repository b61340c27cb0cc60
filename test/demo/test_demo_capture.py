"""What arms reported, put together by stamp."""

import numpy as np
import pytest

pytest.importorskip("rclpy", reason="rclpy is not installed")

from lagrangian_ff.demo.capture import Track, recording_of, tracking
from lagrangian_ff.demo.errors import DemoError

JOINTS = ("a", "b")
START = 1_700_000_000_000_000_000
RATE = 500.0


def track(count: int, offset: float = 0.0, first: int = START) -> Track:
    """Samples every 2 ms; position grows with time."""
    stamp = first + 2_000_000 * np.arange(count, dtype=np.int64)
    position = (stamp - START)[:, None] / 1e9 * np.array([1.0, 2.0]) + offset
    return Track(JOINTS, stamp, position, np.ones_like(position), 3.0 * np.ones_like(position))


def test_the_error_is_reference_less_measured_by_stamp() -> None:
    measured = track(600, first=START - 100 * 2_000_000)
    reference = track(900, offset=0.01, first=START - 50 * 2_000_000)
    found = tracking("run", measured, reference, START, 0.8, RATE)
    assert len(found.time) == 401
    assert found.time[0] == 0.0
    assert found.time[-1] == pytest.approx(0.8)
    np.testing.assert_allclose(found.error, 0.01, atol=1e-12)
    assert found.total == pytest.approx(0.01)


def test_samples_without_their_reference_do_not_count() -> None:
    measured = track(501)
    reference = measured.take(np.arange(0, 501, 1) != 7)
    found = tracking("run", measured, reference, START, 1.0, RATE)
    assert len(found.time) == 500
    np.testing.assert_allclose(found.error, 0.0)


def test_too_few_samples_are_no_run() -> None:
    with pytest.raises(DemoError, match=r"run 'all': 101 of 500"):
        tracking("all", track(101), track(900), START, 1.0, RATE)


def test_a_track_becomes_a_recording() -> None:
    recording = recording_of(track(10), "the arm")
    assert recording.start == START / 1e9
    np.testing.assert_allclose(recording.time, 0.002 * np.arange(10))
    np.testing.assert_allclose(recording.effort, 3.0)
    assert recording.joints == JOINTS


def test_a_track_is_cut_by_stamps() -> None:
    part = track(100).between(START + 20_000_000, START + 40_000_000)
    assert len(part.stamp) == 11
    assert part.position[0, 0] == pytest.approx(0.02)
