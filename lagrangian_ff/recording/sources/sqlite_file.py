"""sqlite3 files of rosbag2 without damage, read by SQLite itself."""

import sqlite3
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path
from urllib.parse import quote

from lagrangian_ff import budget
from lagrangian_ff.recording.sources.sqlite_salvage import shortfall

_STEPS = 100_000
"""Steps of SQLite's machine between two looks at how many there were."""
_LEAST, _PER_BYTE = 10_000_000, 20
"""Steps that a file may take. A message takes about 20, and has far more bytes than one."""


class UnreadableError(Exception):
    """SQLite cannot read the file, or not to its end; the text says why."""


class SqliteFile:
    """A sqlite3 file without damage.

    Args:
        path: the file, perhaps a copy.

    Attributes:
        topics: message type and number of messages, by topic.
        damage: empty; what is damaged is unreadable here.

    Raises:
        UnreadableError: also while messages are read.
    """

    damage = ""

    def __init__(self, path: Path) -> None:
        self._path = path
        if damage := shortfall(path):
            raise UnreadableError(damage)
        self._most = (_LEAST + _PER_BYTE * path.stat().st_size) // _STEPS
        self.topics: dict[str, tuple[str, int]] = {}
        kinds = "SELECT count(*) FROM sqlite_master WHERE type='table' AND name IN (?, ?)"
        if list(self._query(kinds, "messages", "topics")) != [(2,)]:  # a view could be endless
            raise UnreadableError("it lacks the table messages or topics")
        counts = dict(self._query("SELECT topic_id, count(*) FROM messages GROUP BY topic_id"))
        for number, name, kind in self._query("SELECT id, name, type FROM topics"):
            if not (isinstance(name, str) and isinstance(kind, str)):
                raise UnreadableError("a topic has no name or type")
            _, before = self.topics.get(name, ("", 0))
            self.topics[name] = (kind, before + counts.get(number, 0))

    def messages(self, topic: str) -> Iterator[tuple[int, bytes]]:
        """Yield the time received in ns and the serialized message, in order of arrival."""
        found = self._query(
            "SELECT timestamp, data FROM messages "
            "WHERE topic_id IN (SELECT id FROM topics WHERE name = ?) ORDER BY timestamp",
            topic,
        )
        for received, data in found:
            if not isinstance(received, int):  # sqlite does not check types
                raise UnreadableError(f"a message was received at {received!r}")
            if not isinstance(data, bytes):
                raise UnreadableError(f"a message is of the type {type(data).__name__}")
            yield received, data

    def _query(self, text: str, *given: str) -> Iterator[tuple]:
        steps = iter(range(self._most))
        try:
            name = f"file:{quote(str(self._path.absolute()))}?mode=ro&immutable=1"
            with closing(sqlite3.connect(name, uri=True)) as connection:
                connection.set_progress_handler(lambda: next(steps, -1) < 0, _STEPS)
                connection.execute("PRAGMA trusted_schema=OFF")
                if hasattr(connection, "setlimit"):  # Python 3.11 and later
                    connection.setlimit(sqlite3.SQLITE_LIMIT_LENGTH, 2 * budget.MESSAGE)
                yield from connection.execute(text, given)
        except (sqlite3.Error, UnicodeError, MemoryError) as error:
            raise UnreadableError(str(error) or type(error).__name__) from error
