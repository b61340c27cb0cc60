"""Unpacks compressed recordings, up to a limit of size. The libraries for it are optional."""

from collections.abc import Iterator
from contextlib import contextmanager
from functools import cached_property
from pathlib import Path
from types import ModuleType
from typing import Any

from lagrangian_ff import budget
from lagrangian_ff.errors import RecordingError

_ZSTD_MAGIC = b"\x28\xb5\x2f\xfd"
_PIECE = 2048  # bytes of zstd that are unpacked at once: each may become 32 KiB


class MissingLibraryError(RecordingError):
    """A recording is compressed, and the library that unpacks it is not installed."""


def unpack_chunk(compression: str, data: memoryview, size: int) -> bytes | memoryview | None:
    """Return at most one byte more than the size; None if nothing can be unpacked.

    Raises:
        MissingLibraryError: see there.
    """
    if compression == "":
        return data
    if compression == "zstd":
        zstandard = _zstandard()
        try:
            return bytes(zstandard.ZstdDecompressor().stream_reader(data).read(size + 1))
        except (zstandard.ZstdError, MemoryError):
            return None
    if compression == "lz4":
        frame = _lz4()
        try:
            return bytes(frame.LZ4FrameDecompressor().decompress(data, size + 1))
        except (RuntimeError, MemoryError):
            return None
    return None


def unpack_file(path: Path, target: Path) -> bool:
    """Unpack a file of zstd up to its damage; return whether that is the end.

    Raises:
        RecordingError: it unpacks to more than a file may.
        MissingLibraryError: see there.
    """
    zstandard = _zstandard()
    size = budget.file_size(path, RecordingError)
    left = budget.unpacked(size)
    frame = zstandard.ZstdDecompressor().decompressobj()
    begun = False
    with path.open("rb") as packed, target.open("wb") as unpacked:
        while part := packed.read(_PIECE):
            while part:
                begun = True
                try:
                    content = frame.decompress(part)
                except zstandard.ZstdError:
                    return False
                left -= len(content)
                if left < 0:
                    raise RecordingError(
                        f"{path}: unpacks to more than {budget.in_words(budget.unpacked(size))}, "
                        f"which a recording of {budget.in_words(size)} does not; if it is one, "
                        "unpack it first: zstd -d FILE"
                    )
                unpacked.write(content)
                part = frame.unused_data if frame.eof else b""
                if frame.eof:
                    frame = zstandard.ZstdDecompressor().decompressobj()
                    begun = False
    return not begun


class Allowance:
    """Unpacks the messages of a file until they are more than a file of its size may hold.

    Args:
        name: the file, or folder of files, that the user gave, packed or not: what is packed
            twice has one allowance.
    """

    def __init__(self, name: Path) -> None:
        files = name.iterdir() if name.is_dir() else [name]
        self._size, self._name = sum(file.stat().st_size for file in files), name
        self._left = budget.unpacked(self._size)

    def unpacked(self, data: bytes) -> bytes:
        """Return a message without its compression; nothing if that is damaged.

        Raises:
            RecordingError: the messages so far are more than the file may hold.
            MissingLibraryError: see there.
        """
        if data[:4] == _ZSTD_MAGIC:
            data = self._message(data)
        if len(data) > budget.MESSAGE:
            data = b""
        self._left -= len(data)
        if self._left < 0:
            raise RecordingError(
                f"{self._name}: its messages hold more than "
                f"{budget.in_words(budget.unpacked(self._size))}, which a recording of "
                f"{budget.in_words(self._size)} does not; not read"
            )
        return data

    def _message(self, data: bytes) -> bytes:
        zstandard = _zstandard()
        try:
            # What a frame claims to hold is allocated before it is unpacked.
            claimed = zstandard.frame_content_size(data)
            if claimed > budget.MESSAGE:
                return b""
            if claimed >= 0:
                return bytes(self._zstd.decompress(data))
            return bytes(self._zstd.stream_reader(data).read(budget.MESSAGE + 1))
        except (zstandard.ZstdError, MemoryError):
            return b""

    @cached_property
    def _zstd(self) -> Any:
        return _zstandard().ZstdDecompressor()


def _zstandard() -> ModuleType:
    with _named_if_missing("zstandard"):
        import zstandard
    return zstandard


def _lz4() -> ModuleType:
    with _named_if_missing("lz4"):
        import lz4.frame
    return lz4.frame


@contextmanager
def _named_if_missing(name: str) -> Iterator[None]:
    try:
        yield
    except ImportError as error:
        raise MissingLibraryError(
            f"it is compressed, and {name} is not installed, which unpacks it "
            f"(apt install python3-{name}, or pip install {name})"
        ) from error
