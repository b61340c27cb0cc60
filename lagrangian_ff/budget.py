"""Limits of what reading a file may cost, in proportion to its size, for every reader.

No file, damaged or made to do harm, may exhaust memory, disk or patience: what is larger than here
is refused with the package's own error before it is unpacked, parsed or computed with.
docs/recordings.md states these limits for users.
"""

import stat
from pathlib import Path

from lagrangian_ff.errors import UserError

MIB = 1 << 20
RATIO = 200
"""Bytes unpacked per byte of a file. Joint states of an arm at rest reach 100."""
FLOOR = 32 * MIB
"""Bytes that a file may unpack to, however small."""
MOST = 16 << 30
"""Bytes that a file may unpack to on disk or in memory, however large."""
CHUNK = 256 * MIB
"""Bytes of an unpacked chunk of MCAP; rosbag2 makes them of 0.75 MiB."""
MESSAGE = 16 * MIB
"""Bytes of a message."""
JOINTS = 1_000
"""Joints of a recording, a trajectory or a robot."""
COLUMNS = 10_000
"""Columns of a table."""
CELL = 1_000
"""Characters of a cell of a table, on average over its line."""
TABLE = 32
"""Bytes of the table of joint states per byte of their messages; other publishers' are empty."""
TEXT = 64 * MIB
"""Bytes of a text that is parsed as a whole, such as a URDF."""
DEPTH = 100
"""Elements of XML inside each other."""
LARGEST = 1e9
"""Largest position and effort of a joint, in any unit: squares of more hide all others."""
LATEST = 1e20
"""Latest stamp, in any unit: dates in ns are about 2e18."""


def unpacked(size: int, most: int | None = MOST) -> int:
    """Return the bytes to which a file of this size may unpack."""
    allowed = FLOOR + RATIO * size
    return allowed if most is None else min(allowed, most)


def in_words(size: float) -> str:
    """Return a number of bytes as people read it."""
    for unit in ("bytes", "KiB", "MiB", "GiB", "TiB"):
        if size < 1024 or unit == "TiB":
            break
        size /= 1024
    return f"{size:.4g} {unit}"


def file_size(path: Path, error: type[UserError]) -> int:
    """Return the bytes of an ordinary file.

    A device or a pipe has no size that could bound what reading it costs, and a pipe without a
    writer blocks for ever.

    Raises:
        UserError: of the given kind, if it is a folder, a pipe, a socket or a device.
        OSError: there is no such file, or it cannot be looked at.
    """
    found = path.stat()
    if stat.S_ISREG(found.st_mode):
        return found.st_size
    kind = next(
        (
            word
            for test, word in (
                (stat.S_ISDIR, "a folder"),
                (stat.S_ISFIFO, "a pipe"),
                (stat.S_ISSOCK, "a socket"),
            )
            if test(found.st_mode)
        ),
        "a device",
    )
    hint = "" if kind == "a folder" else "; copy what it gives into a file first"
    raise error(f"{path}: is {kind}, expected a file{hint}")


def text_of(path: Path, error: type[UserError], errors: str = "strict") -> str:
    """Return the text of an ordinary file in UTF-8.

    Args:
        errors: what to do with bytes that are no text, as for `bytes.decode`.

    Raises:
        UserError: of the given kind, if it is no ordinary file, or is larger than `TEXT`.
        OSError, UnicodeDecodeError: it cannot be read, or is no text.
    """
    size = file_size(path, error)
    if size > TEXT:
        raise error(f"{path}: has {in_words(size)}, expected a text of at most {in_words(TEXT)}")
    with path.open("rb") as file:
        return file.read(TEXT).decode("utf-8", errors)
