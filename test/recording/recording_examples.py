"""Recordings and bags that the tests of this folder share."""

from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore

from lagrangian_ff.recording import Recording

Floats = NDArray[np.float64]

STORE = get_typestore(Stores.ROS2_JAZZY)
TYPE = "sensor_msgs/msg/JointState"
SHARED = Path(__file__).parents[3] / "shared" / "data"


def swinging(
    samples: int = 1000,
    rate: float = 500.0,
    joints: tuple[str, ...] = ("shoulder", "elbow", "wrist"),
    start: float = 1_700_000_000.0,
) -> Recording:
    """Joints that swing at 0.5 Hz and above with effort in proportion to acceleration."""
    time = np.round(np.arange(samples) / rate, 9)
    omega: Floats = 2 * np.pi * (0.5 + 0.3 * np.arange(len(joints), dtype=np.float64))
    angle: Floats = np.outer(time, omega)
    return Recording(
        joints=joints,
        time=time,
        position=np.sin(angle),
        velocity=omega * np.cos(angle),
        effort=3.0 - omega**2 * np.sin(angle),
        start=start,
    )


def message(
    stamp_ns: int,
    names: Iterable[str],
    position: Iterable[float],
    velocity: Iterable[float] = (),
    effort: Iterable[float] = (),
) -> bytes:
    """A JointState serialized by the library `rosbags`, which shares no code with ours."""
    kinds = STORE.types
    stamp = kinds["builtin_interfaces/msg/Time"](sec=stamp_ns // 10**9, nanosec=stamp_ns % 10**9)
    header = kinds["std_msgs/msg/Header"](stamp=stamp, frame_id="base_link")
    state = kinds[TYPE](
        header=header,
        name=list(names),
        position=np.array(list(position), dtype=np.float64),
        velocity=np.array(list(velocity), dtype=np.float64),
        effort=np.array(list(effort), dtype=np.float64),
    )
    return bytes(STORE.serialize_cdr(state, TYPE))


def messages_of(recording: Recording) -> list[tuple[int, bytes]]:
    """Every sample as a message, received when it was stamped."""
    stamps = round(recording.start * 1e9) + np.round(recording.time * 1e9).astype(np.int64)
    rows = zip(recording.position, recording.velocity, recording.effort, strict=True)
    return [
        (int(stamp), message(int(stamp), recording.joints, *row))
        for stamp, row in zip(stamps, rows, strict=True)
    ]


def decoded(data: bytes | memoryview) -> Any:
    """A JointState read by the library `rosbags`."""
    return STORE.deserialize_cdr(data, TYPE)


def foreign_bag(
    path: Path,
    messages: Iterable[tuple[int, bytes]],
    storage: str = "mcap",
    compression: str = "none",
    topic: str = "/joint_states",
    others: Iterable[str] = (),
) -> Path:
    """A bag written by `rosbags`; `others` are further JointState topics with one message."""
    messages = list(messages)
    writer = Writer(path, version=9, storage_plugin=StoragePlugin[storage.upper()])
    if compression != "none":
        writer.set_compression(CompressionMode[compression.upper()], CompressionFormat.ZSTD)
    with writer:
        connection = writer.add_connection(topic, TYPE, typestore=STORE)
        for other in others:
            extra = writer.add_connection(other, TYPE, typestore=STORE)
            writer.write(extra, messages[0][0], message(messages[0][0], ["x"], [0.0]))
        for received, data in messages:
            writer.write(connection, received, data)
    return path


def equal(first: Floats, second: Floats) -> bool:
    """Same numbers, NaN in the same places."""
    return np.array_equal(first, second, equal_nan=True)


def assert_same(found: Recording, expected: Recording, tolerance: float = 0.0) -> None:
    """Same joints and numbers; times to `tolerance` seconds."""
    assert found.joints == expected.joints
    assert len(found) == len(expected)
    assert np.abs(found.time - expected.time).max() <= tolerance
    for quantity in ("position", "velocity", "effort"):
        assert equal(getattr(found, quantity), getattr(expected, quantity)), quantity
