"""Write rosbag2 directories that survive a kill of the process."""

import json
import shutil
from collections.abc import Sequence
from contextlib import AbstractContextManager
from functools import cache
from os import PathLike
from pathlib import Path

import numpy as np
from mcap.writer import CompressionType, Writer
from numpy.typing import ArrayLike
from rosbags.typesys import Stores, get_typestore

from lagrangian_ff.arrays import Floats
from lagrangian_ff.errors import RecordingError
from lagrangian_ff.files import whole
from lagrangian_ff.progress import Progress, silent
from lagrangian_ff.recording.joint_state import MESSAGE_TYPE, JointStateEncoder
from lagrangian_ff.recording.recording import QUANTITIES, Recording
from lagrangian_ff.recording.sources.bag import is_bag

_BLOCK = 4096
_DISTRO = "jazzy"


class BagWriter(AbstractContextManager["BagWriter"]):
    """Appends joint states to a new rosbag2 directory (MCAP).

    Each message is handed to the operating system as it is appended: a kill of the process loses
    none, a power failure may. `close` adds index and metadata.yaml; `load` can do without. For use
    by one thread.

    Args:
        path: the directory to make.
        topic: of messages that name no other.
        joints: names for `append`.
        overwrite: replace an existing bag.

    Raises:
        RecordingError: the path exists or cannot be written; also from every append.
    """

    def __init__(
        self,
        path: str | PathLike[str],
        *,
        topic: str = "joint_states",
        joints: Sequence[str] = (),
        overwrite: bool = False,
    ) -> None:
        self.path = Path(path)
        self.count = 0
        self._topic = topic
        self._joints = tuple(joints)
        self._encoders: dict[tuple[bool, bool], JointStateEncoder] = {}
        self._channels: dict[str, int] = {}
        self._counts: dict[str, int] = {}
        self._first: int | None = None
        self._latest = 0
        _make_directory(self.path, overwrite=overwrite)
        self._file_name = f"{self.path.name}_0.mcap"
        try:
            self._file = (self.path / self._file_name).open("xb")
        except OSError as error:
            raise self._unwritable(error) from error
        # Without chunks every message is readable once written, as in rosbag2's `fastwrite`.
        self._mcap = Writer(self._file, use_chunking=False, compression=CompressionType.NONE)
        self._mcap.start(profile="ros2", library="lagrangian_ff")
        definition, _ = _joint_state_type()
        self._schema = self._mcap.register_schema(MESSAGE_TYPE, "ros2msg", definition.encode())
        self._channel(topic)
        self._file.flush()

    def append_raw(self, data: bytes, stamp_ns: int, topic: str | None = None) -> None:
        """Append a serialized JointState (CDR) received at `stamp_ns` (since the epoch)."""
        if self._file.closed:
            raise RecordingError(f"{self.path}: the bag is closed; nothing can be appended")
        topic = self._topic if topic is None else topic
        channel = self._channel(topic)
        # Readers without an index need times that never decrease; the header keeps its own.
        self._latest = max(self._latest, stamp_ns)
        if self._first is None:
            self._first = self._latest
        try:
            self._mcap.add_message(
                channel_id=channel,
                log_time=self._latest,
                publish_time=max(0, stamp_ns),
                sequence=self.count,
                data=data,
            )
            self._file.flush()
        except OSError as error:
            raise self._unwritable(error) from error
        self.count += 1
        self._counts[topic] += 1

    def append(
        self,
        time: float,
        position: ArrayLike,
        velocity: ArrayLike | None = None,
        effort: ArrayLike | None = None,
    ) -> None:
        """Append one sample of the joints: `time` in s since the epoch, the others (N,)."""
        stamp = round(time * 1e9)
        values = [
            None if given is None else self._row(name, given)
            for name, given in zip(QUANTITIES, (position, velocity, effort), strict=True)
        ]
        key = (values[1] is not None, values[2] is not None)
        if key not in self._encoders:
            self._encoders[key] = JointStateEncoder(self._joints, velocity=key[0], effort=key[1])
        nothing = np.empty((1, 0))
        rows = [nothing if row is None else row for row in values]
        message = self._encoders[key].encode(np.array([stamp]), *rows)[0]
        self.append_raw(message, stamp)

    def close(self) -> None:
        """Write index and metadata.yaml and end appending; may be repeated."""
        if self._file.closed:
            return
        try:
            self._mcap.finish()
            self._file.close()
            with whole(self.path / "metadata.yaml") as made:
                made.write_text(self._metadata(), encoding="utf-8")
        except OSError as error:
            raise self._unwritable(error) from error

    def __exit__(self, *_: object) -> None:
        self.close()

    def _row(self, name: str, given: ArrayLike) -> Floats:
        row = np.asarray(given, dtype=np.float64)
        if row.shape != (len(self._joints),):
            raise RecordingError(
                f"{self.path}: {name} has shape {row.shape}, expected ({len(self._joints)},) "
                "for the joints given to BagWriter"
            )
        return row[np.newaxis]

    def _channel(self, topic: str) -> int:
        if topic not in self._channels:
            self._channels[topic] = self._mcap.register_channel(
                topic=_absolute(topic),
                message_encoding="cdr",
                schema_id=self._schema,
                metadata={"offered_qos_profiles": ""},
            )
            self._counts[topic] = 0
        return self._channels[topic]

    def _unwritable(self, error: OSError) -> RecordingError:
        return RecordingError(f"{self.path}: cannot be written: {error.strerror or error}")

    def _metadata(self) -> str:
        start = self._first or 0
        spans = {
            "starting_time": {"nanoseconds_since_epoch": start},
            "duration": {"nanoseconds": self._latest - start},
            "message_count": self.count,
        }
        _, digest = _joint_state_type()
        topics = [
            {
                "topic_metadata": {
                    "name": _absolute(topic),
                    "type": MESSAGE_TYPE,
                    "serialization_format": "cdr",
                    "offered_qos_profiles": [],
                    "type_description_hash": digest,
                },
                "message_count": count,
            }
            for topic, count in self._counts.items()
        ]
        information = {
            "version": 9,
            "storage_identifier": "mcap",
            "relative_file_paths": [self._file_name],
            **spans,
            "topics_with_message_count": topics,
            "compression_format": "",
            "compression_mode": "",
            "files": [{"path": self._file_name, **spans}],
            "custom_data": None,
            "ros_distro": _DISTRO,
        }
        # JSON is YAML, and needs no further library.
        return json.dumps({"rosbag2_bagfile_information": information}, indent=2) + "\n"


def write_bag(
    path: str | PathLike[str],
    recording: Recording,
    *,
    topic: str = "joint_states",
    overwrite: bool = False,
    progress: Progress = silent,
) -> Path:
    """Write a recording as a rosbag2 directory (MCAP); return the path.

    Header stamps are `start` + `time`, to the nanosecond; velocity or effort that is NaN
    throughout is left empty in the messages.

    Raises:
        RecordingError: the path exists and `overwrite` is false, or cannot be written; a stamp
            is before 1970 or after 2038.
    """
    stamps = round(recording.start * 1e9) + np.round(recording.time * 1e9).astype(np.int64)
    if stamps.size and (stamps.min() < 0 or stamps.max() >= 2**31 * 10**9):
        raise RecordingError(
            f"{recording.source}: stamps from {stamps.min() / 1e9:.3f} s to "
            f"{stamps.max() / 1e9:.3f} s do not fit a ROS 2 message; shift `time` or `start`"
        )
    encoder = JointStateEncoder(
        recording.joints,
        velocity=not np.isnan(recording.velocity).all(),
        effort=not np.isnan(recording.effort).all(),
    )
    with BagWriter(path, topic=topic, overwrite=overwrite) as bag:
        for first in range(0, len(recording), _BLOCK):
            part = slice(first, first + _BLOCK)
            tables = (getattr(recording, name)[part] for name in QUANTITIES)
            messages = encoder.encode(stamps[part], *tables)
            for stamp, message in zip(stamps[part].tolist(), messages, strict=True):
                bag.append_raw(message, stamp)
            progress(first / len(recording), f"write {bag.path.name}")
    progress(1.0, f"wrote {bag.path.name}")
    return bag.path


def _make_directory(path: Path, *, overwrite: bool) -> None:
    try:
        if path.exists():
            if not overwrite:
                raise RecordingError(f"{path}: exists already; not overwritten")
            if path.is_dir() and not is_bag(path):
                raise RecordingError(f"{path}: a directory that is not a bag; not overwritten")
            if path.is_dir():
                shutil.rmtree(path)
            else:
                path.unlink()
        path.mkdir(parents=True)
    except OSError as error:
        raise RecordingError(f"{path}: cannot be written: {error.strerror or error}") from error


def _absolute(topic: str) -> str:
    return topic if topic.startswith("/") else f"/{topic}"


@cache
def _joint_state_type() -> tuple[str, str]:
    """Return definition and hash of the message type."""
    store = get_typestore(Stores.ROS2_JAZZY)
    definition, _ = store.generate_msgdef(MESSAGE_TYPE, ros_version=2)
    return definition, store.hash_rihs01(MESSAGE_TYPE)
