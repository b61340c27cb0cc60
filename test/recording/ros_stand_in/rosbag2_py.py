"""A stand-in for ROS' rosbag2_py, on the library `rosbags`: the calls that we make, and its rules.

Source of the calls: rosbag2_py/src/rosbag2_py of ros2/rosbag2.
"""

from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import NamedTuple

from rosbags import rosbag2
from rosbags.interfaces import Connection
from rosbags.typesys import Stores, get_typestore


class ConverterOptions(NamedTuple):
    input_serialization_format: str
    output_serialization_format: str


class StorageOptions(SimpleNamespace):
    def __init__(
        self,
        uri: str,
        storage_id: str = "",
        storage_preset_profile: str = "",
        max_cache_size: int = 0,
    ) -> None:
        assert storage_id in {"", "mcap"}
        assert storage_preset_profile in {"", "fastwrite"}
        super().__init__(uri=uri)


class TopicMetadata(SimpleNamespace):
    def __init__(self, id: int, name: str, type: str, serialization_format: str) -> None:
        assert serialization_format == "cdr"
        super().__init__(name=name, type=type)


class StorageFilter(SimpleNamespace):
    def __init__(self, topics: list[str]) -> None:
        super().__init__(topics=topics)


class SequentialWriter:
    def __init__(self) -> None:
        self._topics: dict[str, Connection] = {}

    def open(self, storage: StorageOptions, converter: ConverterOptions) -> None:
        if Path(storage.uri).exists():
            raise RuntimeError("Bag directory already exists")
        plugin = rosbag2.StoragePlugin.MCAP
        self._writer = rosbag2.Writer(Path(storage.uri), version=9, storage_plugin=plugin)
        self._writer.open()

    def create_topic(self, topic: TopicMetadata) -> None:
        store = get_typestore(Stores.ROS2_JAZZY)
        made = self._writer.add_connection(topic.name, topic.type, typestore=store)
        self._topics[topic.name] = made

    def write(self, topic: str, message: bytes, stamp: int) -> None:
        if topic not in self._topics:
            raise RuntimeError(f"Topic {topic} has not been created")
        self._writer.write(self._topics[topic], stamp, message)

    def close(self) -> None:
        self._writer.close()


class SequentialReader:
    compressed = False

    def open(self, storage: StorageOptions, converter: ConverterOptions) -> None:
        try:
            self._reader = rosbag2.Reader(Path(storage.uri))
            self._reader.open()
        except (rosbag2.ReaderError, OSError) as error:
            raise RuntimeError(str(error)) from error
        if bool(self._reader.compression_mode) != self.compressed:
            raise ValueError("the compression mode is another reader's")
        self._messages: Iterator[tuple[Connection, int, bytes]] = self._reader.messages()
        self._next = next(self._messages, None)

    def get_all_topics_and_types(self) -> list[TopicMetadata]:
        return [TopicMetadata(0, c.topic, c.msgtype, "cdr") for c in self._reader.connections]

    def set_filter(self, wanted: StorageFilter) -> None:
        chosen = [c for c in self._reader.connections if c.topic in wanted.topics]
        self._messages = self._reader.messages(chosen)
        self._next = next(self._messages, None)

    def has_next(self) -> bool:
        return self._next is not None

    def read_next(self) -> tuple[str, bytes, int]:
        if self._next is None:
            raise RuntimeError("Bag is at end. No next message.")
        connection, stamp, data = self._next
        self._next = next(self._messages, None)
        return connection.topic, bytes(data), stamp


class SequentialCompressionReader(SequentialReader):
    compressed = True
