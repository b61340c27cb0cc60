"""Write rosbag2 directories that survive a kill of the process."""

import json
from contextlib import AbstractContextManager
from os import PathLike
from pathlib import Path

import numpy as np
from mcap.writer import CompressionType, Writer

from lagrangian_ff.errors import RecordingError
from lagrangian_ff.files import whole
from lagrangian_ff.progress import Progress, silent
from lagrangian_ff.recording.joint_state import MESSAGE_TYPE, JointStateEncoder, typestore
from lagrangian_ff.recording.recording import QUANTITIES, Recording

_BLOCK = 4096
_DISTRO = "jazzy"


class BagWriter(AbstractContextManager["BagWriter"]):
    """Appends serialized joint states to a new rosbag2 directory (MCAP).

    Each message is handed to the operating system as it is appended: a kill of the process loses
    none, a power failure may. `close` adds index and metadata.yaml; `load` can do without. For use
    by one thread.

    Args:
        path: the directory to make.
        topic: of all messages.

    Raises:
        RecordingError: the path exists or cannot be written; also from every append.
    """

    def __init__(self, path: str | PathLike[str], *, topic: str = "joint_states") -> None:
        self.path = Path(path)
        self.count = 0
        self._topic = topic if topic.startswith("/") else f"/{topic}"
        self._first: int | None = None
        self._latest = 0
        self._file_name = f"{self.path.name}_0.mcap"
        try:
            self.path.mkdir(parents=True)
            self._file = (self.path / self._file_name).open("xb")
        except FileExistsError:
            raise RecordingError(f"{self.path}: exists already; not overwritten") from None
        except OSError as error:
            raise self._unwritable(error) from error
        # Without chunks every message is readable once written, as in rosbag2's `fastwrite`.
        self._mcap = Writer(self._file, use_chunking=False, compression=CompressionType.NONE)
        self._mcap.start(profile="ros2", library="lagrangian_ff")
        definition, _ = typestore().generate_msgdef(MESSAGE_TYPE, ros_version=2)
        schema = self._mcap.register_schema(MESSAGE_TYPE, "ros2msg", definition.encode())
        self._channel = self._mcap.register_channel(
            self._topic, "cdr", schema, metadata={"offered_qos_profiles": ""}
        )
        self._file.flush()

    def append(self, data: bytes, stamp_ns: int) -> None:
        """Append a serialized JointState (CDR) received at `stamp_ns` (since the epoch)."""
        if self._file.closed:
            raise RecordingError(f"{self.path}: the bag is closed; nothing can be appended")
        # Readers without an index need times that never decrease; the header keeps its own.
        self._latest = max(self._latest, stamp_ns)
        if self._first is None:
            self._first = self._latest
        sent = max(0, stamp_ns)
        try:
            self._mcap.add_message(self._channel, self._latest, data, sent, sequence=self.count)
            self._file.flush()
        except OSError as error:
            raise self._unwritable(error) from error
        self.count += 1

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

    def _unwritable(self, error: OSError) -> RecordingError:
        return RecordingError(f"{self.path}: cannot be written: {error.strerror or error}")

    def _metadata(self) -> str:
        start = self._first or 0
        spans = {
            "starting_time": {"nanoseconds_since_epoch": start},
            "duration": {"nanoseconds": self._latest - start},
            "message_count": self.count,
        }
        topic = {
            "name": self._topic,
            "type": MESSAGE_TYPE,
            "serialization_format": "cdr",
            "offered_qos_profiles": [],
            "type_description_hash": typestore().hash_rihs01(MESSAGE_TYPE),
        }
        information = {
            "version": 9,
            "storage_identifier": "mcap",
            "relative_file_paths": [self._file_name],
            **spans,
            "topics_with_message_count": [{"topic_metadata": topic, "message_count": self.count}],
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
    progress: Progress = silent,
) -> Path:
    """Write a recording as a rosbag2 directory (MCAP); return the path.

    Header stamps are `start` + `time`, to the nanosecond; velocity or effort that is NaN
    throughout is left empty in the messages.

    Raises:
        RecordingError: the path exists or cannot be written; a stamp is before 1970 or after 2038.
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
    with BagWriter(path, topic=topic) as bag:
        for first in range(0, len(recording), _BLOCK):
            part = slice(first, first + _BLOCK)
            tables = (getattr(recording, name)[part] for name in QUANTITIES)
            messages = encoder.encode(stamps[part], *tables)
            for stamp, message in zip(stamps[part].tolist(), messages, strict=True):
                bag.append(message, stamp)
            progress(first / len(recording), f"write {bag.path.name}")
    progress(1.0, f"wrote {bag.path.name}")
    return bag.path
