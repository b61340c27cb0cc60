"""Temperatures of joints, from every kind of file to the motion's clock."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from recording_examples import STORE, foreign_bag, messages_of
from rosbags.rosbag2 import StoragePlugin, Writer

from lagrangian_ff.errors import RecordingError
from lagrangian_ff.recording import Recording, condition, load, write_csv, write_npz

TYPE = "sensor_msgs/msg/Temperature"
JOINTS = ("joint_1", "joint_10")


def warming(time: NDArray[np.float64], joint: int) -> NDArray[np.float64]:
    """°C of a joint: it warms up along a straight line."""
    return 20.0 + joint + 0.5 * time


@pytest.fixture(scope="module")
def moving() -> Recording:
    """Return 10 s of two joints at 100 Hz, without temperatures."""
    time = np.arange(0.0, 10.0, 0.01)
    q = np.sin(np.outer(time, (2.0, 3.0)))
    return Recording(JOINTS, time, q, np.gradient(q, time, axis=0), -q, start=1.7e9)


@pytest.fixture
def warm(moving: Recording) -> Recording:
    """Return the same with the temperature of the first joint, every half a second."""
    temperature = np.full(moving.position.shape, np.nan)
    temperature[::50, 0] = warming(moving.time[::50], 0)
    return replace(moving, temperature=temperature)


@pytest.mark.parametrize(("write", "ending"), [(write_csv, "csv"), (write_npz, "npz")])
def test_a_table_keeps_it(write, ending, warm: Recording, tmp_path: Path) -> None:  # type: ignore[no-untyped-def]
    found = load(write(tmp_path / f"warm.{ending}", warm))
    assert found.temperature is not None
    assert warm.temperature is not None
    np.testing.assert_array_equal(found.temperature, warm.temperature)
    (first,) = found.select(("joint_1",)).tables["temperature"].T
    np.testing.assert_array_equal(first, warm.temperature[:, 0])


@pytest.mark.parametrize(("write", "ending"), [(write_csv, "csv"), (write_npz, "npz")])
def test_a_table_without_it_has_none(write, ending, moving: Recording, tmp_path: Path) -> None:  # type: ignore[no-untyped-def]
    assert load(write(tmp_path / f"cold.{ending}", moving)).temperature is None


def test_a_column_of_one_joint_is_enough(tmp_path: Path) -> None:
    file = tmp_path / "one.csv"
    file.write_text("time,position/a,effort/a,position/b,effort/b,temperature/b\n0,1,2,3,4,31.5\n")
    found = load(file)
    assert found.temperature is not None
    np.testing.assert_array_equal(found.temperature, [[np.nan, 31.5]])


def test_a_table_of_another_shape_is_refused(moving: Recording) -> None:
    with pytest.raises(RecordingError, match=r"temperature has shape \(2,\), expected"):
        replace(moving, temperature=np.array([20.0, 21.0]))


def test_it_follows_the_clock_of_the_motion(warm: Recording) -> None:
    motion = condition(warm)
    assert motion.temperature is not None
    np.testing.assert_allclose(
        motion.temperature[:, 0], warming(np.minimum(motion.time, 9.5), 0), atol=1e-9
    )
    assert np.isnan(motion.temperature[:, 1]).all()
    assert any("temperature of joint_1: 20.0 to 24.8 °C" in note for note in motion.notes)
    part = motion.select(("joint_1",)).take(slice(3, 5)).temperature
    assert part is not None
    np.testing.assert_array_equal(part, motion.temperature[3:5, :1])
    assert condition(replace(warm, temperature=None)).temperature is None


def bag_with(
    path: Path, moving: Recording, topics: dict[str, tuple[str, int]], late: float = 0.0
) -> Recording:
    """Return a bag's recording; of each topic the frame_id and the joint's number."""
    foreign_bag(path / "states", messages_of(moving))
    kind = STORE.types[TYPE]
    header, stamp = (
        STORE.types[name] for name in ("std_msgs/msg/Header", "builtin_interfaces/msg/Time")
    )
    with Writer(path / "bag", version=9, storage_plugin=StoragePlugin.MCAP) as writer:
        states = writer.add_connection(
            "/joint_states", "sensor_msgs/msg/JointState", typestore=STORE
        )
        for at, data in messages_of(moving):
            writer.write(states, at, data)
        for topic, (frame, joint) in topics.items():
            connection = writer.add_connection(topic, TYPE, typestore=STORE)
            for time in np.arange(0.0, 10.0, 0.25):
                at = round((moving.start + time + late) * 1e9)
                value = float(warming(np.array(time), joint))
                said = kind(header(stamp(at // 10**9, at % 10**9), frame), value, 0.0)
                writer.write(connection, at, STORE.serialize_cdr(said, TYPE))
    return load(path / "bag")


@pytest.mark.parametrize(
    ("topic", "frame"),
    [
        ("/drives/joint_10/temperature", ""),
        ("/temperature", "joint_10"),
        ("/t_joint_10_motor", "x"),
    ],
)
def test_a_topic_of_a_bag_names_its_joint(
    topic: str, frame: str, moving: Recording, tmp_path: Path
) -> None:
    found = bag_with(tmp_path, moving, {topic: (frame, 1)})
    assert found.temperature is not None
    assert np.isnan(found.temperature[:, 0]).all()
    np.testing.assert_allclose(
        found.temperature[:, 1], warming(np.minimum(found.time, 9.75), 1), atol=1e-6
    )
    (note,) = found.notes
    assert f"temperature on {topic}" in note
    assert "is that of joint_10: 40 messages" in note


def test_what_names_no_joint_or_is_of_another_time_is_not_used(
    moving: Recording, tmp_path: Path
) -> None:
    found = bag_with(tmp_path, moving, {"/room": ("", 0), "/joint_2/t": ("", 0)})
    assert found.temperature is None
    assert all("names none or several of the joints joint_1, joint_10" in n for n in found.notes)
    assert len(found.notes) == 2
    late = bag_with(tmp_path / "late", moving, {"/joint_1": ("", 0)}, late=100.0)
    assert late.temperature is None
    assert "has stamps 90 s away" in late.notes[0]


def test_a_second_thermometer_is_named(moving: Recording, tmp_path: Path) -> None:
    topics = {"/joint_1/gear": ("", 0), "/joint_1/motor": ("", 0)}
    found = bag_with(tmp_path, moving, topics)
    assert found.temperature is not None
    assert (
        "is of joint_1 too, whose temperature is that on /joint_1/gear: not used" in found.notes[1]
    )
