"""MCAP, read record by record: whole files, files that were not closed, or cut off anywhere.

Only what lies in the file decides what is read: no index is needed, and none can send the reader
round in circles. Chunks are unpacked one after the other, none beyond the size that it states.
Source: the MCAP format (mcap.dev/spec).
"""

import struct
import zlib
from collections import Counter
from collections.abc import Iterator
from functools import cached_property
from pathlib import Path
from typing import BinaryIO, TypeAlias

from lagrangian_ff import budget
from lagrangian_ff.errors import RecordingError
from lagrangian_ff.recording.sources.packing import unpack_chunk

_MAGIC = b"\x89MCAP0\r\n"
_HEAD = struct.Struct("<BQ")  # opcode and length of a record
_MESSAGE = struct.Struct("<HIQQ")  # channel, number, time received, time sent
_CHUNK = struct.Struct("<QQQII")  # first and last time, size, checksum, length of what follows
_END = _HEAD.size + 20 + len(_MAGIC)  # bytes of the closing record and what follows
FOOTER, SCHEMA, CHANNEL, MESSAGE, CHUNK, STATISTICS, DATA_END = 2, 3, 4, 5, 6, 11, 15
_READ = (FOOTER, SCHEMA, CHANNEL, MESSAGE, CHUNK, STATISTICS, DATA_END)
_IN_CHUNKS = (SCHEMA, CHANNEL, MESSAGE)
_SHORTEST = 14  # bytes of a record in a chunk: a schema without name, encoding and data
_BROKEN = (struct.error, UnicodeDecodeError)

Found: TypeAlias = tuple[int, memoryview]
"""A record: its opcode and its content."""


class McapFile:
    """The readable part of an MCAP file.

    Args:
        path: the file, perhaps a copy.
        name: the file the user gave, for messages.

    Attributes:
        damage: what is wrong with the file; complete only after `messages` has ended.

    Raises:
        RecordingError: it is not an MCAP file at all, or unpacks to more than a file may; also
            while messages are read. MissingLibraryError: nothing installed unpacks it.
    """

    def __init__(self, path: Path, name: Path) -> None:
        self._path = path
        self._name = name
        self._size = budget.file_size(path, RecordingError)
        self.damage = ""
        with path.open("rb") as file:
            if file.read(len(_MAGIC)) != _MAGIC:
                raise RecordingError(f"{name}: not an MCAP file (it does not begin as one)")

    @cached_property
    def topics(self) -> dict[str, tuple[str, int]]:
        """Return message type and number of messages, by topic."""
        return self._summary() or self._counted()

    def messages(self, topic: str) -> Iterator[tuple[int, bytes]]:
        """Yield the time received in ns and the serialized message, in order of arrival."""
        channels: dict[int, bool] = {}
        for opcode, content in self._records():
            if opcode == MESSAGE:
                number, _, received, _ = _MESSAGE.unpack_from(content)
                if channels.get(number):
                    yield received, bytes(content[_MESSAGE.size :])
            elif opcode == CHANNEL:
                number, _, name = _channel(content)
                channels[number] = name == topic

    def _summary(self) -> dict[str, tuple[str, int]]:
        """Return the topics as the summary of a file that was closed has them; else nothing."""
        with self._path.open("rb") as file:
            try:
                file.seek(max(0, self._size - _END))
                opcode, _, start = struct.unpack_from("<BQQ", end := file.read(_END))
                if opcode != FOOTER or not end.endswith(_MAGIC) or not 0 < start < self._size:
                    return {}
                file.seek(start)
                wanted = (SCHEMA, CHANNEL, STATISTICS)
                records = [found for found in self._plain(file) if found[0] in wanted]
                held = [found for found in records if found[0] == STATISTICS]
                if not held:
                    return {}
                numbers = struct.iter_unpack("<HQ", held[0][1][46:])
                return _topics(records, Counter(dict(numbers)))
            except _BROKEN:
                return {}
            finally:
                self.damage = ""

    def _counted(self) -> dict[str, tuple[str, int]]:
        """Return the topics of a file without a summary."""
        counts: Counter[int] = Counter()
        described = []
        for opcode, content in self._records():
            if opcode == MESSAGE:
                counts[_MESSAGE.unpack_from(content)[0]] += 1
            else:
                described.append((opcode, memoryview(bytes(content))))
        return _topics(described, counts)

    def _records(self) -> Iterator[Found]:
        """Yield schemas, channels and messages up to the end of the data, those in chunks too."""
        size = self._name.stat().st_size  # of the file given: what is packed twice is packed
        allowed = left = budget.unpacked(size, None)
        self.damage = ""
        with self._path.open("rb") as file:
            file.seek(len(_MAGIC))
            for opcode, content in self._plain(file):
                if opcode == CHUNK:
                    inside = self._unpacked(content, file.tell() - len(content) - _HEAD.size)
                    left -= len(inside)
                    if left < 0:
                        raise RecordingError(
                            f"{self._name}: its chunks unpack to more than "
                            f"{budget.in_words(allowed)}, which a recording of "
                            f"{budget.in_words(size)} does not; not read"
                        )
                    yield from self._sound(_inside(inside))
                elif opcode != STATISTICS:
                    yield from self._sound(iter([(opcode, content)]))

    def _plain(self, file: BinaryIO) -> Iterator[Found]:
        """Yield the records from here up to the end of the data; of a cut chunk what there is."""
        while len(head := file.read(_HEAD.size)) == _HEAD.size:
            opcode, length = _HEAD.unpack(head)
            offset = file.tell() - _HEAD.size
            if opcode in (FOOTER, DATA_END):
                return
            cut = offset + _HEAD.size + length > self._size
            if opcode in _READ and (not cut or opcode == CHUNK):
                yield opcode, memoryview(file.read(min(length, self._size)))
            elif not cut:
                file.seek(length, 1)
            if cut:
                self._damaged(f"it ends inside the record at byte {offset}")
                return
        self._damaged("it ends without its closing record")

    def _sound(self, records: Iterator[Found]) -> Iterator[Found]:
        """Yield the schemas, channels and messages that are in order."""
        for opcode, content in records:
            try:
                if opcode == MESSAGE:
                    if not _MESSAGE.size <= len(content) <= budget.MESSAGE:
                        self._damaged(f"a message has {budget.in_words(len(content))}")
                        continue
                elif opcode == CHANNEL:
                    _channel(content)
                elif opcode == SCHEMA:
                    _schema(content)
                else:
                    continue
            except _BROKEN:
                self._damaged("the description of a topic cannot be read")
                continue
            yield opcode, content

    def _unpacked(self, record: memoryview, offset: int) -> memoryview:
        """Return the content of a chunk, or of one that is cut off what there is of it."""
        try:
            _, _, size, checksum, length = _CHUNK.unpack_from(record)
            at = _CHUNK.size + length
            compression = str(record[_CHUNK.size : at], "utf-8")
            (packed,) = struct.unpack_from("<Q", record, at)
        except _BROKEN:
            self._damaged(f"the chunk at byte {offset} cannot be read")
            return memoryview(b"")
        data = record[at + 8 : at + 8 + packed]
        if size > budget.CHUNK and compression:
            self._damaged(f"the chunk at byte {offset} claims to hold {budget.in_words(size)}")
            return memoryview(b"")
        content = unpack_chunk(compression, data, size)
        whole = len(data) == packed
        if content is None or (whole and len(content) != size):
            self._damaged(f"the chunk at byte {offset} does not unpack")
            return memoryview(b"")
        if whole and checksum and zlib.crc32(content) != checksum:
            self._damaged(f"the chunk at byte {offset} fails its checksum")
            return memoryview(b"")
        return memoryview(content)

    def _damaged(self, what: str) -> None:
        self.damage = self.damage or what


def _inside(content: memoryview) -> Iterator[Found]:
    """Yield the records of a chunk, up to what cannot be one."""
    at, size = 0, len(content)
    while at + _HEAD.size <= size:
        opcode, length = _HEAD.unpack_from(content, at)
        at += _HEAD.size
        if opcode not in _IN_CHUNKS or length < _SHORTEST or at + length > size:
            return
        yield opcode, content[at : at + length]
        at += length


def _text(content: memoryview, at: int) -> tuple[str, int]:
    """Return a text and the offset behind it."""
    (length,) = struct.unpack_from("<I", content, at)
    end = at + 4 + length
    if end > len(content):
        raise struct.error("ends inside a text")
    return str(content[at + 4 : end], "utf-8"), end


def _channel(content: memoryview) -> tuple[int, int, str]:
    """Return the channel's number, that of its schema, and the topic."""
    number, schema = struct.unpack_from("<HH", content)
    return number, schema, _text(content, 4)[0]


def _schema(content: memoryview) -> tuple[int, str]:
    """Return the number of a schema, and the type of message."""
    return struct.unpack_from("<H", content)[0], _text(content, 2)[0]


def _topics(records: list[Found], counts: Counter[int]) -> dict[str, tuple[str, int]]:
    """Return type and number of messages by topic, from schemas, channels and their counts."""
    schemas = dict(_schema(content) for opcode, content in records if opcode == SCHEMA)
    channels = {
        number: (schema, topic)
        for number, schema, topic in (_channel(c) for opcode, c in records if opcode == CHANNEL)
    }
    found: dict[str, tuple[str, int]] = {}
    for number, (schema, topic) in channels.items():
        kind, before = found.get(topic, (schemas.get(schema, ""), 0))
        found[topic] = (kind, before + counts[number])
    return found
