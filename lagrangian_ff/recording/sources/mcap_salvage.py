"""MCAP record by record, for files without a footer or cut off anywhere.

Needs no index: every record is framed by its kind and length, so all that lies before the cut
is found, also inside the chunk that is cut. Source: MCAP format specification (mcap.dev/spec).
"""

import zlib
from collections.abc import Iterator
from pathlib import Path

import lz4.frame  # type: ignore[import-untyped]
import zstandard

from lagrangian_ff.errors import RecordingError

_MAGIC = b"\x89MCAP0\r\n"
_FOOTER, _SCHEMA, _CHANNEL, _MESSAGE, _CHUNK, _DATA_END = 2, 3, 4, 5, 6, 15
_FRAME = 9  # kind and length of a record
_MESSAGE_HEAD = 22  # channel, sequence, time logged, time published


class McapSalvage:
    """What can be read of an MCAP file.

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
        self._channels: dict[int, str] = {}
        self.topics = self._scan()

    def messages(self, topic: str) -> Iterator[tuple[int, bytes]]:
        """Time received in ns and serialized message, in order of arrival."""
        self._channels = {}
        for kind, body in self._records():
            if kind == _CHANNEL:
                number, name, _ = _channel(body)
                self._channels[number] = name
            elif kind == _MESSAGE and self._channels.get(_int(body, 0, 2)) == topic:
                yield _int(body, 6, 8), body[_MESSAGE_HEAD:]

    def _scan(self) -> dict[str, tuple[str, int]]:
        schemas: dict[int, str] = {}
        topics: dict[str, tuple[str, int]] = {}
        for kind, body in self._records():
            if kind == _SCHEMA:
                schemas[_int(body, 0, 2)] = _text(body, 2)[0]
            elif kind == _CHANNEL:
                number, name, schema = _channel(body)
                self._channels[number] = name
                topics.setdefault(name, (schemas.get(schema, ""), 0))
            elif kind == _MESSAGE and (name := self._channels.get(_int(body, 0, 2), "")):
                topics[name] = (topics[name][0], topics[name][1] + 1)
        return topics

    def _records(self) -> Iterator[tuple[int, bytes]]:
        """Schemas, channels and messages, those in chunks too, up to the damage."""
        size = self._path.stat().st_size
        self.damage = ""
        with self._path.open("rb") as file:
            if file.read(len(_MAGIC)) != _MAGIC:
                raise RecordingError(f"{self._name}: not an MCAP file (it does not begin as one)")
            while True:
                offset = file.tell()
                head = file.read(_FRAME)
                if len(head) < _FRAME:
                    self._damaged("it ends without its closing record")
                    return
                kind, length = head[0], _int(head, 1, 8)
                if kind in (_DATA_END, _FOOTER):
                    return
                whole = offset + _FRAME + length <= size
                if kind == _CHUNK:
                    yield from self._chunk(file.read(min(length, size)), offset, whole=whole)
                elif whole and kind in (_SCHEMA, _CHANNEL, _MESSAGE):
                    body = file.read(length)
                    if kind == _MESSAGE and length < _MESSAGE_HEAD:
                        self._damaged(f"record at byte {offset} is too short")
                        return
                    yield kind, body
                elif whole:
                    file.seek(length, 1)
                if not whole:
                    self._damaged(f"it ends inside the record at byte {offset}")
                    return

    def _chunk(self, body: bytes, offset: int, *, whole: bool) -> Iterator[tuple[int, bytes]]:
        if len(body) < 40:
            return
        checksum = _int(body, 24, 4)
        compression, start = _text(body, 28)
        content = _unpack(compression, body[start + 8 :])
        if content is None or (whole and len(content) != _int(body, 16, 8)):
            self._damaged(f"the chunk at byte {offset} does not unpack")
            return
        if whole and checksum and zlib.crc32(content) != checksum:
            self._damaged(f"the chunk at byte {offset} fails its checksum")
            return
        position = 0
        while position + _FRAME <= len(content):
            kind, length = content[position], _int(content, position + 1, 8)
            position += _FRAME
            if position + length > len(content):
                return
            if kind in (_SCHEMA, _CHANNEL) or (kind == _MESSAGE and length >= _MESSAGE_HEAD):
                yield kind, content[position : position + length]
            position += length

    def _damaged(self, what: str) -> None:
        self.damage = self.damage or what


def _int(data: bytes, offset: int, size: int) -> int:
    return int.from_bytes(data[offset : offset + size], "little")


def _text(data: bytes, offset: int) -> tuple[str, int]:
    """A length-prefixed text and the offset behind it."""
    end = offset + 4 + _int(data, offset, 4)
    return data[offset + 4 : end].decode("utf-8", errors="replace"), end


def _channel(body: bytes) -> tuple[int, str, int]:
    """Number, topic and number of the schema."""
    return _int(body, 0, 2), _text(body, 4)[0], _int(body, 2, 2)


def _unpack(compression: str, data: bytes) -> bytes | None:
    """As much as unpacks of data that may be cut off; None for what cannot be unpacked."""
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
