"""Recording and Motion: selection, blocks, concatenation."""

import numpy as np
import pytest
from recording_examples import swinging

from lagrangian_ff.errors import RecordingError
from lagrangian_ff.recording import Motion, Recording, concatenate, condition


def motion() -> Motion:
    return condition(swinging(2000))


def test_arrays_must_fit_the_joints() -> None:
    time = np.arange(3.0)
    with pytest.raises(RecordingError, match=r"effort has shape \(3, 1\)"):
        Recording(("a", "b"), time, np.zeros((3, 2)), np.zeros((3, 2)), np.zeros((3, 1)))


def test_a_joint_cannot_appear_twice() -> None:
    values = np.zeros((1, 2))
    with pytest.raises(RecordingError, match="twice"):
        Recording(("a", "a"), np.zeros(1), values, values, values)


def test_selected_joints_keep_their_columns() -> None:
    recording = swinging(10)
    chosen = recording.select(("wrist", "shoulder"))
    assert np.array_equal(chosen.position[:, 0], recording.position[:, 2])
    assert np.array_equal(chosen.effort[:, 1], recording.effort[:, 0])
    with pytest.raises(RecordingError, match="no joint gripper; it holds shoulder"):
        recording.select(("gripper",))


def test_blocks_last_as_long_as_asked_and_respect_segments() -> None:
    whole = motion()
    number = whole.blocks(0.5)
    for block in np.unique(number):
        assert np.ptp(whole.time[number == block]) < 0.5 + 1e-9
    two = concatenate([whole, whole])
    number = two.blocks(1000.0)
    assert np.array_equal(number, np.repeat([0, 1], len(whole)))


def test_concatenation_sorts_columns_by_the_first() -> None:
    whole = motion()
    turned = whole.select(tuple(reversed(whole.joints)))
    both = concatenate([whole, turned])
    assert np.array_equal(both.tau[: len(whole)], both.tau[len(whole) :])
    assert np.array_equal(np.unique(both.segment), [0, 1])
    with pytest.raises(RecordingError, match="select common joints"):
        concatenate([whole, whole.select(("elbow",))])


def test_recordings_after_one_another_are_put_end_to_end() -> None:
    whole = motion()
    elapsed = concatenate([whole, whole]).elapsed
    assert elapsed[0] == 0.0
    assert np.all(np.diff(elapsed) >= 0.0)
    assert elapsed[-1] == pytest.approx(2.0 * np.ptp(whole.time))
    assert motion().take(slice(0, 0)).elapsed.shape == (0,)
