"""MCAP without its index, for files that were not closed or are cut off anywhere.

The stream reader of the library `mcap` reads record by record up to the cut; of a chunk that is
cut, what can be unpacked is read here.
"""

import struct
import zlib
from collections import Counter
from collections.abc import Iterator
from io import BytesIO
from pathlib import Path

import lz4.frame  # type: ignore[import-untyped]
import zstandard
from mcap.data_stream import ReadDataStream
from mcap.exceptions import McapError
from mcap.opcode import Opcode
from mcap.records import Channel, Chunk, DataEnd, Footer, McapRecord, Message, Schema
from mcap.stream_reader import StreamReader

from lagrangian_ff.errors import RecordingError

_MAGIC = b"\x89MCAP0\r\n"
_FRAME = 9  # opcode and length of a record
_BROKEN = (McapError, struct.error, ValueError, OverflowError, MemoryError)
"""Errors of the library on damaged records."""


class McapSalvage:
    """The readable part of an MCAP file.

    Args:
        path: the file, perhaps a copy.
        name: the file the user gave, for messages.

    Attributes:
        topics: message type and number of messages, by topic.
        damage: what is wrong with the file.

    Raises:
        RecordingError: it is not an MCAP file at all.
    """

    def __init__(self, path: Path, name: Path) -> None:
        self._path = path
        self._name = name
        self.damage = ""
        schemas: dict[int, str] = {}
        types: dict[str, str] = {}
        counts: Counter[str] = Counter()
        for record, topic in self._records():
            if isinstance(record, Schema):
                schemas[record.id] = record.name
            elif isinstance(record, Channel):
                types.setdefault(topic, schemas.get(record.schema_id, ""))
            elif topic:
                counts[topic] += 1
        self.topics = {topic: (kind, counts[topic]) for topic, kind in types.items()}

    def messages(self, topic: str) -> Iterator[tuple[int, bytes]]:
        """Yield the time received in ns and the serialized message, in order of arrival."""
        for record, its_topic in self._records():
            if isinstance(record, Message) and its_topic == topic:
                yield record.log_time, record.data

    def _records(self) -> Iterator[tuple[McapRecord, str]]:
        """Yield schemas, channels and messages, these two with their topic."""
        topics: dict[int, str] = {}
        for record in self._flat():
            if isinstance(record, Channel):
                topics[record.id] = record.topic
                yield record, record.topic
            elif isinstance(record, Message):
                yield record, topics.get(record.channel_id, "")
            elif isinstance(record, Schema):
                yield record, ""

    def _flat(self) -> Iterator[McapRecord]:
        """Yield the records up to the end of the data, those in chunks too."""
        size = self._path.stat().st_size
        self.damage = ""
        with self._path.open("rb") as file:
            if file.read(len(_MAGIC)) != _MAGIC:
                raise RecordingError(f"{self._name}: not an MCAP file (it does not begin as one)")
            while True:
                offset = file.tell()
                reader = StreamReader(
                    file, skip_magic=True, emit_chunks=True, record_size_limit=size
                )
                try:
                    for record in reader.records:
                        if isinstance(record, DataEnd | Footer):
                            return
                        if isinstance(record, Chunk):
                            yield from self._inside(record, offset, whole=True)
                        else:
                            yield record
                        offset = file.tell()
                except _BROKEN:
                    pass
                file.seek(offset)
                head = file.read(_FRAME)
                end = offset + _FRAME + int.from_bytes(head[1:], "little")
                if len(head) < _FRAME:
                    self._damaged("it ends without its closing record")
                    return
                if end > size:
                    if head[0] == Opcode.CHUNK:
                        yield from self._cut_chunk(file.read(), offset)
                    self._damaged(f"it ends inside the record at byte {offset}")
                    return
                self._damaged(f"the record at byte {offset} cannot be read")
                file.seek(end)

    def _cut_chunk(self, body: bytes, offset: int) -> Iterator[McapRecord]:
        try:
            chunk = Chunk.read(ReadDataStream(BytesIO(body)))
        except _BROKEN:
            return
        yield from self._inside(chunk, offset, whole=False)

    def _inside(self, chunk: Chunk, offset: int, *, whole: bool) -> Iterator[McapRecord]:
        content = _unpack(chunk.compression, chunk.data)
        if content is None or (whole and len(content) != chunk.uncompressed_size):
            self._damaged(f"the chunk at byte {offset} does not unpack")
            return
        checksum = chunk.uncompressed_crc
        if whole and checksum and zlib.crc32(content) != checksum:
            self._damaged(f"the chunk at byte {offset} fails its checksum")
            return
        try:
            yield from StreamReader(BytesIO(content), skip_magic=True).records
        except _BROKEN:  # the end of the content, or of what there is of it
            return

    def _damaged(self, what: str) -> None:
        self.damage = self.damage or what


def _unpack(compression: str, data: bytes) -> bytes | None:
    """Return as much as unpacks of data that may be cut off; None if nothing can be unpacked."""
    try:
        if compression == "":
            return data
        if compression == "zstd":
            return zstandard.ZstdDecompressor().decompressobj().decompress(data)
        if compression == "lz4":
            return bytes(lz4.frame.LZ4FrameDecompressor().decompress(data))
    except (zstandard.ZstdError, RuntimeError):
        return None
    return None
