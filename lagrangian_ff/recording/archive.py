"""Archives of plain arrays as `np.savez` writes them (.npz): a zip of .npy files.

Nothing is believed that an archive says of its size: what it claims is compared with what it has
before memory is taken for it. Arrays of Python objects are never read, since that executes code.
"""

import math
import struct
import tokenize
import zipfile
import zlib
from collections.abc import Collection
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from lagrangian_ff import budget
from lagrangian_ff.errors import UserError

_ZIP, _ARRAY, _PICKLE = b"PK", b"\x93NUMPY", b"\x80"
_COMPRESSIONS = (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED)
_KINDS = "biufUS"  # of NumPy: truth values, numbers and texts
_UNPACKING = (EOFError, RuntimeError, zipfile.BadZipFile, zlib.error, struct.error, OverflowError)
_PARSING = (
    ValueError, TypeError, LookupError, MemoryError, SyntaxError, AttributeError,
    tokenize.TokenError,
)  # fmt: skip
_DAMAGED = (*_UNPACKING, *_PARSING)
"""Errors of a damaged archive: a flipped bit can reach the zip's flags (RuntimeError) and the text
of an array's shape, which cannot be parsed (SyntaxError, TokenError) or is huge (MemoryError)."""


@dataclass(frozen=True)
class Archive:
    """The arrays of an archive.

    Attributes:
        arrays: those that were wanted, by name.
        names: of all that it holds.
    """

    arrays: dict[str, Any]
    names: tuple[str, ...]


def read_archive(
    path: Path, wanted: Collection[str], error: type[UserError], expected: str = "an archive"
) -> Archive:
    """Return the arrays of these names that an archive holds.

    Args:
        wanted: names; other arrays are not read.
        error: the kind to raise.
        expected: what the file should be, for messages.

    Raises:
        UserError: of the given kind; it is no archive of arrays, is damaged, or unpacks to more
            than a file of its size may.
        OSError: the file cannot be read.
    """
    size = budget.file_size(path, error)
    with path.open("rb") as file:
        begin = file.read(len(_ARRAY))
        if not begin.startswith(_ZIP):
            raise error(f"{path} is not {expected}: it {_other(begin)}")
        try:
            with zipfile.ZipFile(file) as archive:
                members = {one.filename.removesuffix(".npy"): one for one in archive.infolist()}
                chosen = {name: one for name, one in members.items() if name in wanted}
                claimed = sum(one.file_size for one in chosen.values())
                if claimed > budget.unpacked(size):
                    raise error(
                        f"{path}: claims to unpack to {budget.in_words(claimed)}, a file of "
                        f"{budget.in_words(size)} may hold at most "
                        f"{budget.in_words(budget.unpacked(size))}; not read"
                    )
                arrays = {
                    name: _array(archive, one, f"{path}: array {name}", error)
                    for name, one in chosen.items()
                }
        except (OSError, *_DAMAGED) as why:  # a damaged place in the zip's index cannot be sought
            raise error(f"{path}: damaged, or no .npz archive: {_reason(why)}") from why
    return Archive(arrays, tuple(members))


def _other(begin: bytes) -> str:
    """Return what a file is that begins like this."""
    if not begin:
        return "is empty"
    if begin == _ARRAY:
        return "is a single array (.npy)"
    if begin.startswith(_PICKLE):
        return "is a pickle, which is never read since that can execute code"
    return "does not begin as one"


def _reason(why: Exception) -> str:
    """Return what an error says, without NumPy's advice to read what is not safe."""
    text = str(why)
    if isinstance(why, SyntaxError | tokenize.TokenError) or "parse" in text:
        return "the shape of an array cannot be parsed"
    return text if text and "pickle" not in text else type(why).__name__


def _array(
    archive: zipfile.ZipFile, member: zipfile.ZipInfo, place: str, error: type[UserError]
) -> Any:
    if member.compress_type not in _COMPRESSIONS:
        raise error(f"{place} is compressed by method {member.compress_type}, expected deflate")
    with archive.open(member) as file:
        version = np.lib.format.read_magic(file)
        if version not in ((1, 0), (2, 0)):
            raise error(f"{place} is in the format {version}, expected 1.0 or 2.0")
        read = getattr(np.lib.format, f"read_array_header_{version[0]}_0")
        shape, by_column, kind = read(file)
        if kind.hasobject:
            raise error(
                f"{place} holds Python objects, which are never read since that can execute code; "
                "expected numbers: convert it with np.asarray(..., dtype=float)"
            )
        size = math.prod(shape) * kind.itemsize
        left = member.file_size - file.tell()
        if (
            kind.kind not in _KINDS
            or kind.itemsize == 0
            or size != left
            or min(shape, default=1) < 0
        ):
            raise error(f"{place} claims the shape {shape} of {kind}, and has {left} bytes")
        held = bytearray(size)
        view, at = memoryview(held), 0
        while at < size:
            part = file.read(budget.MIB)
            if not part:
                raise EOFError("ends inside an array")
            view[at : at + len(part)] = part
            at += len(part)
    if kind.kind == "U":  # Python makes texts of any numbers, and fails when they are printed
        point = np.frombuffer(held, dtype=np.dtype(np.uint32).newbyteorder(kind.byteorder))
        if ((point > 0x10FFFF) | ((point >= 0xD800) & (point < 0xE000))).any():
            raise error(f"{place} holds what is no text")
    return np.frombuffer(held, dtype=kind).reshape(shape, order="F" if by_column else "C")
