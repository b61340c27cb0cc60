"""sqlite3 page by page, for rosbag2 files that were cut off.

Rows lie in leaf pages, which can be read without the tree above them. rosbag2 only appends: the
remaining pages are the beginning of the recording. No library reads a file without its tree:
SQLite refuses it, and its own recovery is an extension that Python does not have. Source:
SQLite file format (sqlite.org/fileformat2.html).
"""

import sqlite3
from collections.abc import Iterator
from pathlib import Path
from typing import BinaryIO

from lagrangian_ff import budget
from lagrangian_ff.errors import RecordingError

_MAGIC = b"SQLite format 3\0"
_LEAF = 0x0D
_LEAST_CELL = 4  # bytes of a cell with its pointer
_FILE_HEAD = 100  # the file header, on the first page only
_SIZES = {1: 1, 2: 2, 3: 3, 4: 4, 5: 6, 6: 8, 7: 8}  # bytes of integers, and of a float

Value = int | bytes | str | None


class SqliteSalvage:
    """The readable part of a sqlite3 file of rosbag2.

    Args:
        path: the file, perhaps a copy.
        name: the file the user gave, for messages.

    Attributes:
        topics: message type and number of messages (0: not counted), by topic.
        damage: what is wrong with the file.

    Raises:
        RecordingError: it is not a sqlite3 file at all.
    """

    def __init__(self, path: Path, name: Path) -> None:
        self._path = path
        self._name = name
        self._size = path.stat().st_size
        self.damage = shortfall(path)
        with path.open("rb") as file:
            head = file.read(_FILE_HEAD)
        if head[:16] != _MAGIC:
            raise RecordingError(f"{name}: not a sqlite3 file (it does not begin as one)")
        if len(head) < _FILE_HEAD:
            raise RecordingError(f"{name}: cut off inside its header; nothing can be read")
        self._page = _page_size(head)
        if self._page < 512:
            raise RecordingError(f"{name}: damaged header; nothing can be read")
        self._usable = self._page - head[20]
        self._topics: dict[int, tuple[str, str]] = {}
        for key, row in self._rows():
            match row:
                # The table `topics` as rosbag2 lays it out: key, name, type, serialization.
                case [None, str(topic), str(kind), str(), *_] if "/" in kind:
                    self._topics.setdefault(key, (topic, kind))
        self.topics = {topic: (kind, 0) for topic, kind in self._topics.values()}

    @staticmethod
    def settle(path: Path) -> None:
        """Merge the log beside a private copy of a file into it."""
        try:
            connection = sqlite3.connect(path)
            try:
                connection.execute("SELECT count(*) FROM sqlite_master").fetchone()
                connection.execute("PRAGMA wal_checkpoint(TRUNCATE)")
                connection.execute("PRAGMA journal_mode=DELETE")
            finally:
                connection.close()
        except sqlite3.Error:
            return  # reading the file reports the error

    def messages(self, topic: str) -> Iterator[tuple[int, bytes]]:
        """Yield the time received in ns and the serialized message, in order of arrival."""
        numbers = {number for number, (name, _) in self._topics.items() if name == topic}
        found: dict[int, tuple[int, bytes]] = {}
        for key, row in self._rows():
            match row:
                case [None, int(number), int(received), bytes(data)] if number in numbers:
                    found[key] = (received, data)
        for key in sorted(found):
            yield found[key]

    def _rows(self) -> Iterator[tuple[int, list[Value]]]:
        """Yield key and columns of every row of every table, on the pages that are whole.

        No byte belongs to two rows: cells that overlap, and overflow pages that are referred to
        again and again, are damage. So the work is in proportion to the file.
        """
        pages = self._size // self._page
        self._overflow = pages
        with self._path.open("rb") as file, self._path.open("rb") as beside:
            for number in range(pages):
                page = file.read(self._page)
                start = _FILE_HEAD if number == 0 else 0
                if len(page) < self._page or page[start] != _LEAF:
                    continue
                cells = int.from_bytes(page[start + 3 : start + 5], "big")
                left = self._page
                for cell in range(min(cells, self._page // _LEAST_CELL)):
                    pointer = start + 8 + 2 * cell
                    offset = int.from_bytes(page[pointer : pointer + 2], "big")
                    row, inside = self._cell(page, offset, beside)
                    left -= inside
                    if left < 0:
                        break
                    if row is not None:
                        yield row

    def _cell(
        self, page: bytes, offset: int, file: BinaryIO
    ) -> tuple[tuple[int, list[Value]] | None, int]:
        """Return key and columns of a row, if it can be read, and its bytes in the page."""
        used = _LEAST_CELL
        try:
            length, first = _varint(page, offset)
            key, first = _varint(page, first)
            payload, inside = self._payload(page, first, length, file)
            used = first - offset + inside
            return (None if payload is None else (key, _columns(payload))), used
        except (IndexError, ValueError):
            return None, used

    def _payload(
        self, page: bytes, offset: int, length: int, file: BinaryIO
    ) -> tuple[bytes | None, int]:
        """Return the bytes of a row, if they are all there, and how many are in the page."""
        largest = self._usable - 35
        if length <= largest:
            inside = page[offset : offset + length]
            return (inside if len(inside) == length else None), len(inside)
        least = (self._usable - 12) * 32 // 255 - 23
        local = least + (length - least) % (self._usable - 4)
        local = local if local <= largest else least
        parts = [page[offset : offset + local]]
        left = length - local
        following = int.from_bytes(page[offset + local : offset + local + 4], "big")
        if length > min(self._size, budget.MESSAGE):
            return None, local
        while left > 0:
            self._overflow -= 1
            if self._overflow < 0 or not 1 <= following <= self._size // self._page:
                return None, local
            file.seek((following - 1) * self._page)
            overflow = file.read(self._page)
            following = int.from_bytes(overflow[:4], "big")
            parts.append(overflow[4 : 4 + min(left, self._usable - 4)])
            left -= len(parts[-1])
        return b"".join(parts), local


def shortfall(path: Path) -> str:
    """Return what a sqlite3 file lacks by its own header; empty if it is complete.

    sqlite itself reads the missing part of the last page as zeros.
    """
    size = path.stat().st_size
    with path.open("rb") as file:
        head = file.read(_FILE_HEAD)
    page = _page_size(head)
    counted = head[24:28] == head[92:96]  # else an old version wrote, without this count
    promised = int.from_bytes(head[28:32], "big") * page if counted else 0
    if size < promised:
        return f"{size} of {promised} bytes"
    if page and size % page:
        return "its last page is incomplete"
    return ""


def _page_size(head: bytes) -> int:
    # The format writes 65536, which does not fit, as 1.
    size = int.from_bytes(head[16:18], "big")
    return 65536 if size == 1 else size


def _varint(data: bytes, offset: int) -> tuple[int, int]:
    """Return a number of 1 to 9 bytes and the offset behind it."""
    value = 0
    for index in range(8):
        byte = data[offset + index]
        value = value << 7 | byte & 0x7F
        if byte < 0x80:
            return value, offset + index + 1
    return value << 8 | data[offset + 8], offset + 9


def _columns(payload: bytes) -> list[Value]:
    """Return the values of a row; raise ValueError or IndexError if the bytes are not a row."""
    head, position = _varint(payload, 0)
    kinds = []
    while position < head:
        kind, position = _varint(payload, position)
        kinds.append(kind)
    values: list[Value] = []
    for kind in kinds:
        size = (kind - 12) // 2 if kind >= 12 else _SIZES.get(kind, 0)
        part = payload[position : position + size]
        if len(part) != size:
            raise ValueError("ends inside a value")
        position += size
        if 1 <= kind <= 6:
            values.append(int.from_bytes(part, "big", signed=True))
        elif kind in (8, 9):
            values.append(kind - 8)
        elif kind >= 12:
            values.append(part if kind % 2 == 0 else part.decode("utf-8"))
        else:
            values.append(None)
    return values
