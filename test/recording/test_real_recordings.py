"""Measured recordings of real arms, where they are at hand."""

from pathlib import Path

import numpy as np
import pytest
from recording_examples import SHARED

from lagrangian_ff.recording import Conditioning, condition, inspect, load


def measured(relative: str) -> Path:
    path = SHARED / relative
    if not path.exists():
        pytest.skip(f"the measured recording {relative} is not at hand")
    return path


def test_the_ur10_bag_is_read_as_it_is() -> None:
    path = measured("ur10/ur10_exciting_trajectory/ur10_exciting_trajectory.db3")
    recording = load(path)
    assert len(recording) == 3441
    assert recording.joints[0] == "shoulder_pan_joint"
    assert recording.notes == ()
    found = inspect(recording)
    assert found.rate == pytest.approx(125, rel=1e-6)
    assert found.gaps == found.missing == ()
    motion = condition(recording)
    assert np.unique(motion.segment).size == 1
    inside = np.isin(np.round(recording.time, 3), np.round(motion.time, 3))
    difference = motion.qd - recording.velocity[inside]
    assert (difference.std(axis=0) < 0.02 * recording.velocity.std(axis=0)).all()


@pytest.mark.parametrize("number", [1, 2, 3])
def test_the_lwr4_agrees_with_its_own_velocity_and_acceleration(number: int) -> None:
    path = measured(f"kuka_lwr4/measurements_{number}.npz")
    recording = load(path)
    assert recording.joints == tuple(f"joint_{k}" for k in range(1, 8))
    assert recording.start > 1.4e9
    with np.load(path) as archive:
        acceleration = archive["accelerations"]
    # Theirs are filtered harder, so that only slow motion can be compared closely; at the end
    # of the recording they miss that the arm brakes.
    for bandwidth, share in ((2.0, 0.1), (25.0, 0.2)):
        motion = condition(recording, Conditioning(bandwidth=bandwidth))
        inside = (motion.time > 2) & (motion.time < 23)
        for joint in range(7):
            for values, theirs, allowed in (
                (motion.qd, recording.velocity, 0.05),
                (motion.qdd, acceleration, share),
            ):
                expected = np.interp(motion.time, recording.time, theirs[:, joint])[inside]
                assert np.std(values[inside, joint] - expected) < allowed * np.std(expected)


@pytest.mark.parametrize("number", [1, 2, 3])
def test_the_lwr4_was_sampled_by_a_steady_clock(number: int) -> None:
    recording = load(measured(f"kuka_lwr4/measurements_{number}.npz"))
    motion = condition(recording)
    assert any("steady clock" in note for note in motion.notes)
    believed = condition(recording, Conditioning(clock="stamps"))
    # Late stamps make accelerations that no joint has.
    rough, smooth = (
        np.abs(np.diff(found.qdd[(found.time > 2) & (found.time < 23)], axis=0)).max(axis=0)
        for found in (believed, motion)
    )
    assert (rough > 1.5 * smooth).all()
