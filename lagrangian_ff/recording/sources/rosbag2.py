"""A bag as ROS' own rosbag2_py reads it: where ROS is installed and our readers lack a library."""

from collections.abc import Iterator
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from lagrangian_ff.errors import RecordingError

INSTALL = "apt install ros-jazzy-rosbag2-py"


class Rosbag2:
    """A whole bag, or one file of it that stands alone.

    Raises:
        RecordingError: rosbag2 cannot read it; also while messages are read.
    """

    damage = ""

    def __init__(self, path: Path) -> None:
        self._path = path
        found = self._opened().get_all_topics_and_types()
        # How many messages a topic has is not known; that it has some is likely.
        self.topics = {topic.name: (topic.type, 1) for topic in found}

    def messages(self, topic: str) -> Iterator[tuple[int, bytes]]:
        """Yield the time received in ns and the serialized message, in order of arrival."""
        import rosbag2_py

        reader = self._opened()
        reader.set_filter(rosbag2_py.StorageFilter(topics=[topic]))
        try:
            while reader.has_next():
                _, data, received = reader.read_next()
                yield received, data
        except RuntimeError as error:
            raise self._unreadable(error) from error

    def _opened(self) -> Any:
        import rosbag2_py

        where = rosbag2_py.StorageOptions(uri=str(self._path), storage_id="")
        failed: Exception | None = None
        # The reader of compressed bags refuses those whose metadata names no compression.
        for kind in (rosbag2_py.SequentialCompressionReader, rosbag2_py.SequentialReader):
            reader = kind()
            try:
                reader.open(where, rosbag2_py.ConverterOptions("", ""))
            except (RuntimeError, ValueError) as error:
                failed = error
            else:
                return reader
        raise self._unreadable(failed)

    def _unreadable(self, error: Exception | None) -> RecordingError:
        return RecordingError(
            f"{self._path}: rosbag2 cannot read it ({error}); our own reader is more patient, and "
            "needs zstandard and lz4: apt install python3-zstandard python3-lz4, or pip install "
            "zstandard lz4"
        )


def is_installed() -> bool:
    """Return whether ROS' reader is there."""
    return find_spec("rosbag2_py") is not None
