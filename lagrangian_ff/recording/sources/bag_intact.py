"""One file of a bag as the library `rosbags` reads it."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from lagrangian_ff.recording.sources.sqlite_salvage import shortfall

if TYPE_CHECKING:
    from rosbags.rosbag2 import Reader


class UnreadableError(Exception):
    """`rosbags` refuses the file or breaks off inside it; the text says why."""


class IntactFile:
    """A sqlite3 or MCAP file without damage.

    Raises:
        UnreadableError: also while messages are read.
    """

    damage = ""

    def __init__(self, path: Path) -> None:
        self._path = path
        if path.suffix == ".db3" and (damage := shortfall(path)):
            raise UnreadableError(damage)
        with _translated(), _opened(path) as reader:
            self.topics = _counted(reader)

    def messages(self, topic: str) -> Iterator[tuple[int, bytes]]:
        """Time received in ns and serialized message, in order of arrival."""
        with _translated(), _opened(self._path) as reader:
            connections = [c for c in reader.connections if c.topic == topic]
            if not connections:
                return
            for _, received, data in reader.messages(connections):
                yield received, bytes(data)


def _opened(path: Path) -> "Reader":
    from rosbags.rosbag2 import Reader  # slow to import, and only bags need it

    return Reader(path)


@contextmanager
def _translated() -> Iterator[None]:
    # On damaged input the library raises whatever its parsers meet: struct, index, type,
    # database and compression errors as well as its own.
    try:
        yield
    except Exception as error:
        raise UnreadableError(str(error) or type(error).__name__) from error


def _counted(reader: "Reader") -> dict[str, tuple[str, int]]:
    topics: dict[str, tuple[str, int]] = {}
    for connection in reader.connections:
        _, before = topics.get(connection.topic, ("", 0))
        topics[connection.topic] = (connection.msgtype, before + connection.msgcount)
    return topics
