"""Writes the file of a bag: with the library mcap if it is installed, else with rosbag2_py.

The first hands every message to the operating system at once; rosbag2 keeps up to 4 KiB, which a
kill of the process loses.
"""

import json
from collections.abc import Iterator
from contextlib import contextmanager
from importlib.util import find_spec
from pathlib import Path
from typing import Protocol

from lagrangian_ff.errors import RecordingError
from lagrangian_ff.files import whole
from lagrangian_ff.recording.joint_state import MESSAGE_TYPE

_DISTRO = "jazzy"
_BETWEEN = "=" * 80
_DEFINITION = f"""\
std_msgs/Header header
string[] name
float64[] position
float64[] velocity
float64[] effort
{_BETWEEN}
MSG: std_msgs/Header
builtin_interfaces/Time stamp
string frame_id
{_BETWEEN}
MSG: builtin_interfaces/Time
int32 sec
uint32 nanosec
"""
_TYPE_HASH = "RIHS01_a13ee3a330e346c9d87b5aa18d24e11690752bd33a0350f11c5882bc9179260e"


class BagStorage(Protocol):
    """The open file of a bag with one topic of joint states.

    Raises:
        OSError: it cannot be written; from every call.
    """

    def append(self, data: bytes, received: int, sent: int, number: int) -> None:
        """Append a message (CDR), its times in ns, and how many came before it."""

    def close(self) -> None:
        """Write what a reader finds messages by, and metadata.yaml."""


def open_storage(path: Path, topic: str) -> BagStorage:
    """Return the storage of a new bag, its directory made.

    Raises:
        RecordingError: no library that writes bags is installed.
        OSError: the path exists or cannot be written.
    """
    if find_spec("mcap"):
        return _McapStorage(path, topic)
    if find_spec("rosbag2_py"):
        return _Rosbag2Storage(path, topic)
    raise RecordingError(
        f"{path}: bags are written by rosbag2_py (apt install ros-jazzy-rosbag2-py) or mcap "
        "(pip install mcap); neither is installed"
    )


class _McapStorage:
    def __init__(self, path: Path, topic: str) -> None:
        from mcap.writer import CompressionType, Writer

        self._path, self._topic = path, topic
        self._first: int | None = None
        self._latest = self._count = 0
        self._file_name = f"{path.name}_0.mcap"
        path.mkdir(parents=True)
        self._file = (path / self._file_name).open("xb")
        # Without chunks every message is readable once written, as in rosbag2's `fastwrite`.
        self._mcap = Writer(self._file, use_chunking=False, compression=CompressionType.NONE)
        self._mcap.start(profile="ros2", library="lagrangian_ff")
        schema = self._mcap.register_schema(MESSAGE_TYPE, "ros2msg", _DEFINITION.encode())
        self._channel = self._mcap.register_channel(
            topic, "cdr", schema, metadata={"offered_qos_profiles": ""}
        )
        self._file.flush()

    def append(self, data: bytes, received: int, sent: int, number: int) -> None:
        if self._first is None:
            self._first = received
        self._latest, self._count = received, number + 1
        self._mcap.add_message(self._channel, received, data, sent, sequence=number)
        self._file.flush()

    def close(self) -> None:
        with self._file:
            self._mcap.finish()
        with whole(self._path / "metadata.yaml") as made:
            made.write_text(self._metadata(), encoding="utf-8")

    def _metadata(self) -> str:
        start = self._first or 0
        spans = {
            "starting_time": {"nanoseconds_since_epoch": start},
            "duration": {"nanoseconds": self._latest - start},
            "message_count": self._count,
        }
        topic = {
            "name": self._topic,
            "type": MESSAGE_TYPE,
            "serialization_format": "cdr",
            "offered_qos_profiles": [],
            "type_description_hash": _TYPE_HASH,
        }
        information = {
            "version": 9,
            "storage_identifier": "mcap",
            "relative_file_paths": [self._file_name],
            **spans,
            "topics_with_message_count": [{"topic_metadata": topic, "message_count": self._count}],
            "compression_format": "",
            "compression_mode": "",
            "files": [{"path": self._file_name, **spans}],
            "custom_data": None,
            "ros_distro": _DISTRO,
        }
        # JSON is YAML, and needs no further library.
        return json.dumps({"rosbag2_bagfile_information": information}, indent=2) + "\n"


class _Rosbag2Storage:
    def __init__(self, path: Path, topic: str) -> None:
        import rosbag2_py

        if path.exists():
            raise FileExistsError(path)
        path.parent.mkdir(parents=True, exist_ok=True)
        self._topic = topic
        self._writer = rosbag2_py.SequentialWriter()
        where = rosbag2_py.StorageOptions(
            uri=str(path), storage_id="mcap", storage_preset_profile="fastwrite", max_cache_size=0
        )
        what = rosbag2_py.TopicMetadata(
            id=0, name=topic, type=MESSAGE_TYPE, serialization_format="cdr"
        )
        with _failing_as_files_do():
            self._writer.open(where, rosbag2_py.ConverterOptions("cdr", "cdr"))
            self._writer.create_topic(what)

    def append(self, data: bytes, received: int, sent: int, number: int) -> None:
        with _failing_as_files_do():
            self._writer.write(self._topic, data, received)

    def close(self) -> None:
        # Jazzy's first releases close a bag only when the writer ends.
        with _failing_as_files_do():
            if hasattr(self._writer, "close"):
                self._writer.close()
            del self._writer


@contextmanager
def _failing_as_files_do() -> Iterator[None]:
    """Raise as OSError what rosbag2 raises."""
    try:
        yield
    except RuntimeError as error:
        raise OSError(str(error)) from error
