"""The arm's joint states put together by stamp; a run of the arm, and a refused one."""

from dataclasses import replace
from typing import cast

import numpy as np
import pytest

pytest.importorskip("rclpy", reason="rclpy is not installed")

from lagrangian_ff.arm import Trajectory
from lagrangian_ff.demo.arm_link import ArmLink, Drive, Track, recording_of, tracking
from lagrangian_ff.errors import LostRunError

SECOND = 1_000_000_000
JOINTS = ("a", "b")
START = 1_700_000_000_000_000_000
RATE = 500.0


def track(count: int, offset: float = 0.0, first: int = START) -> Track:
    """Samples every 2 ms; position grows with time."""
    stamp = first + 2_000_000 * np.arange(count, dtype=np.int64)
    position = (stamp - START)[:, None] / 1e9 * np.array([1.0, 2.0]) + offset
    return Track(JOINTS, stamp, position, np.ones_like(position), 3.0 * np.ones_like(position))


def line(duration: float, offset: float = 0.0) -> Trajectory:
    """Where `track` should be, in another order of joints."""
    time = np.linspace(0.0, duration, 5)
    q = time[:, None] * np.array([2.0, 1.0]) + offset
    return Trajectory(time, q, np.ones_like(q) * [2.0, 1.0], np.zeros_like(q), JOINTS[::-1])


def test_the_error_is_reference_less_measured_by_stamp() -> None:
    measured = track(600, first=START - 100 * 2_000_000)
    found = tracking("run", measured, line(0.8, offset=0.01), START, RATE)
    assert len(found.time) == 401
    assert found.time[0] == 0.0
    assert found.time[-1] == pytest.approx(0.8)
    np.testing.assert_allclose(found.error, 0.01, atol=1e-12)
    assert found.total == pytest.approx(0.01)


def test_a_lost_sample_does_no_harm() -> None:
    whole = track(501)
    arrays = ("stamp", "position", "velocity", "effort")
    measured = replace(
        whole, **{name: np.delete(getattr(whole, name), 7, axis=0) for name in arrays}
    )
    found = tracking("run", measured, line(1.0), START, RATE)
    assert len(found.time) == 500
    np.testing.assert_allclose(found.error, 0.0, atol=1e-12)


def test_too_few_samples_are_no_run() -> None:
    with pytest.raises(LostRunError, match=r"run 'all': 101 of 500"):
        tracking("all", track(101), line(1.0), START, RATE)


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


class FakeLink:
    """What a `Drive` asks of an arm."""

    def __init__(self) -> None:
        self.start, self.now, self.refused = 0, 0, 1
        self.measured = self

    def refusals(self) -> tuple[int, str]:
        return self.refused, "joint_6 would jump by 0.5 rad"

    def latest(self) -> int:
        return self.now


@pytest.fixture
def link() -> FakeLink:
    return FakeLink()


@pytest.fixture
def drive(link: FakeLink) -> Drive:
    still = np.zeros((3, 6))
    return Drive(cast(ArmLink, link), Trajectory(np.arange(3.0), still, still, still))


def test_it_is_over_a_little_after_the_end(link: FakeLink, drive: Drive) -> None:
    assert not drive.over()
    link.start, link.now = 5 * SECOND, 6 * SECOND
    assert drive.fraction == pytest.approx(0.5)
    link.now = 7 * SECOND
    assert drive.fraction == 1.0
    assert not drive.over()
    link.now += SECOND
    assert drive.over()


def test_a_refused_motion_ends_the_wait_with_the_reason(link: FakeLink, drive: Drive) -> None:
    link.refused += 1
    with pytest.raises(
        LostRunError, match=r"/arm refused the motion: joint_6 would jump by 0\.5 rad"
    ):
        drive.over()
