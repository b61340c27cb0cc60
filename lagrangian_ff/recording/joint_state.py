"""`sensor_msgs/msg/JointState` in the CDR encoding of ROS 2, thousands of messages at a time.

A publisher repeats the same names and array lengths message after message, so messages of one
size are stacked as the rows of a byte matrix and read by column. The layout is read byte by byte
only when it changes; a general CDR reader would do so for every message. Source of the format:
OMG DDS-XTYPES 1.3, section 7.4 (plain CDR).
"""

import struct
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lagrangian_ff import budget
from lagrangian_ff.arrays import Flags, Floats, Ints
from lagrangian_ff.errors import RecordingError
from lagrangian_ff.recording.recording import require_joints

Bytes = NDArray[np.uint8]

MESSAGE_TYPE = "sensor_msgs/msg/JointState"
_HEADER = 4  # the encapsulation header; alignment counts from behind it
_BATCH = 4096
_LATEST = 2**63 - 1  # ns; MCAP has room for more, in damaged files at least
_QUANTITIES = 3  # position, velocity, effort


class MalformedError(ValueError):
    """The bytes are not a JointState."""


@dataclass(frozen=True)
class Layout:
    """The offsets in a message, which all messages like it share.

    Attributes:
        names: the joints, in the order of the message.
        order: the byte order as NumPy writes it, "<" or ">".
        start: offset of the first position, velocity and effort; -1 if the array is empty.
        fixed: (length,) bytes that must agree for another message to have this layout.
    """

    names: tuple[str, ...]
    order: str
    start: tuple[int, int, int]
    fixed: Flags


def read_layout(data: bytes) -> Layout:
    """Return the layout of one message.

    Raises:
        MalformedError: lengths or encapsulation do not make a JointState.
    """
    if len(data) < _HEADER + 8 or data[0] != 0 or data[1] not in (0, 1):
        raise MalformedError("no plain CDR header")
    byteorder = "little" if data[1] else "big"
    fixed = np.zeros(len(data), dtype=bool)
    fixed[:2] = True
    position = _HEADER + 8  # behind the time stamp

    def aligned(offset: int, size: int) -> int:
        return offset + (_HEADER - offset) % size

    def count() -> int:
        nonlocal position
        first = aligned(position, 4)
        position = first + 4
        if position > len(data):
            raise MalformedError("ends inside a length")
        fixed[first:position] = True
        return int.from_bytes(data[first:position], byteorder)  # type: ignore[arg-type]

    def text() -> slice:
        nonlocal position
        length = count()
        inside = slice(position, position + length)
        position += length
        if position > len(data):
            raise MalformedError("ends inside a text")
        return inside

    text()  # frame_id
    number = count()
    if number > len(data):
        raise MalformedError("more joints than bytes")
    if number == 0:
        raise MalformedError("no joints")
    names = []
    for _ in range(number):
        inside = text()
        fixed[inside] = True
        names.append(data[inside].rstrip(b"\0").decode("utf-8", errors="replace"))
    if len(set(names)) != len(names):
        raise MalformedError("a joint is named twice")
    starts = []
    for _ in range(_QUANTITIES):
        length = count()
        if length not in (0, number):
            raise MalformedError(f"{length} values for {number} joints")
        if length:
            position = aligned(position, 8)
            starts.append(position)
            position += 8 * length
        else:
            starts.append(-1)
    if position > len(data):
        raise MalformedError("ends inside an array")
    order, start = "<" if data[1] else ">", (starts[0], starts[1], starts[2])
    return Layout(tuple(names), order, start, fixed)


@dataclass(frozen=True)
class _Block:
    row: Ints
    columns: Ints
    values: tuple[Floats | None, Floats | None, Floats | None]


class JointStateTable:
    """Collects messages of any joint order or subset into one table.

    Args:
        source: of the messages, for errors.
    """

    def __init__(self, source: str = "joint states") -> None:
        self._source = source
        self._bytes = self._waiting = 0
        self._malformed = 0
        self._columns: dict[str, int] = {}
        self._blocks: list[_Block] = []
        self._stamps: list[Ints] = []
        self._received: list[Ints] = []
        self._rows = 0
        self._pending: list[tuple[int, bytes]] = []

    @property
    def malformed(self) -> int:
        """Return the number of messages that were no JointState or named no joint."""
        self._flush()
        return self._malformed

    def __len__(self) -> int:
        self._flush()
        return self._rows

    def add(self, received: int, data: bytes) -> None:
        """Take one serialized message and the time in ns at which it was received."""
        self._pending.append((min(max(received, 0), _LATEST), data))
        self._bytes += len(data)
        self._waiting += len(data)
        if len(self._pending) >= _BATCH or self._waiting > budget.FLOOR:
            self._flush()

    def mark(self) -> tuple[int, int, int, int]:
        """Return the state of the table, for `rewind`."""
        self._flush()
        return self._rows, self._malformed, len(self._blocks), len(self._stamps)

    def rewind(self, mark: tuple[int, int, int, int]) -> None:
        """Remove the messages added since this mark."""
        self._pending.clear()
        self._rows, self._malformed, blocks, batches = mark
        del self._blocks[blocks:], self._stamps[batches:], self._received[batches:]

    def finish(self) -> tuple[tuple[str, ...], Ints, Ints, Floats, Floats, Floats]:
        """Return joints, header stamps (M,) ns, times received (M,) ns, position, velocity, effort.

        The arrays are (M, N), in order of arrival, NaN if a message had no value. The table is
        empty afterwards.

        Raises:
            RecordingError: more joints than any arm has, or most of a huge table would be empty.
        """
        self._flush()
        require_joints(self._source, len(self._columns))
        shape = (self._rows, len(self._columns))
        size = 8 * _QUANTITIES * shape[0] * shape[1]
        if size > budget.FLOOR + budget.TABLE * self._bytes:
            raise RecordingError(
                f"{self._source}: {shape[0]} messages name {shape[1]} joints, few of them in each: "
                f"a table of {budget.in_words(size)}, nearly empty; record fewer publishers"
            )
        tables = [np.full(shape, np.nan) for _ in range(_QUANTITIES)]
        while self._blocks:
            block = self._blocks.pop()
            for table, values in zip(tables, block.values, strict=True):
                if values is not None:
                    table[np.ix_(block.row, block.columns)] = values
        empty = np.empty(0, dtype=np.int64)
        stamps, received = (np.concatenate([empty, *x]) for x in (self._stamps, self._received))
        return tuple(self._columns), stamps, received, tables[0], tables[1], tables[2]

    def _flush(self) -> None:
        pending, self._pending, self._waiting = self._pending, [], 0
        if not pending:
            return
        stamps = np.zeros(len(pending), dtype=np.int64)
        good = np.zeros(len(pending), dtype=bool)
        blocks: list[_Block] = []
        by_length: dict[int, list[int]] = {}
        for index, (_, data) in enumerate(pending):
            by_length.setdefault(len(data), []).append(index)
        for length, indices in by_length.items():
            matrix = np.frombuffer(b"".join(pending[i][1] for i in indices), dtype=np.uint8)
            matrix = matrix.reshape(len(indices), length)
            left = np.array(indices, dtype=np.int64)
            while left.size:
                try:
                    layout = read_layout(matrix[0].tobytes())
                except MalformedError:
                    self._malformed += 1
                    left, matrix = left[1:], matrix[1:]
                    continue
                alike = (matrix[:, layout.fixed] == matrix[0, layout.fixed]).all(axis=1)
                rows = left[alike]
                good[rows] = True
                stamps[rows], block = self._read(layout, matrix[alike], rows)
                blocks.append(block)
                left, matrix = left[~alike], matrix[~alike]
        number = self._rows + np.cumsum(good) - 1
        self._blocks += [_Block(number[b.row], b.columns, b.values) for b in blocks]
        self._stamps.append(stamps[good])
        received = np.array([time for time, _ in pending], dtype=np.int64)
        self._received.append(received[good])
        self._rows += int(good.sum())

    def _read(self, layout: Layout, matrix: Bytes, rows: Ints) -> tuple[Ints, _Block]:
        columns = np.array(
            [self._columns.setdefault(name, len(self._columns)) for name in layout.names],
            dtype=np.int64,
        )

        def field(first: int, size: int, kind: str) -> NDArray[np.generic]:
            part = np.ascontiguousarray(matrix[:, first : first + size])
            return part.view(layout.order + kind)

        seconds = field(_HEADER, 4, "i4").astype(np.int64)[:, 0]
        nanoseconds = field(_HEADER + 4, 4, "u4").astype(np.int64)[:, 0]
        position, velocity, effort = (
            None if start < 0 else field(start, 8 * len(columns), "f8").astype(np.float64)
            for start in layout.start
        )
        stamps = seconds * 1_000_000_000 + nanoseconds
        return stamps, _Block(rows, columns, (position, velocity, effort))


class JointStateEncoder:
    """Writes messages that share their joints, by filling in one that has their layout.

    Args:
        joints: N names.
        velocity, effort: whether the messages carry these arrays.
    """

    def __init__(
        self, joints: tuple[str, ...], *, velocity: bool = True, effort: bool = True
    ) -> None:
        template = _message(joints, (True, velocity, effort))
        self._start, self._width = read_layout(template).start, 8 * len(joints)
        self._template = np.frombuffer(template, dtype=np.uint8)

    def encode(
        self, stamps: Ints, position: Floats, velocity: Floats, effort: Floats
    ) -> list[bytes]:
        """Return one message a row: stamps (M,) ns, the others (M, N)."""
        rows = np.tile(self._template, (len(stamps), 1))
        rows[:, 4:8] = _as_bytes(stamps // 1_000_000_000, "<i4")
        rows[:, 8:12] = _as_bytes(stamps % 1_000_000_000, "<u4")
        for start, values in zip(self._start, (position, velocity, effort), strict=True):
            if start >= 0:
                rows[:, start : start + self._width] = _as_bytes(values, "<f8")
        return [row.tobytes() for row in rows]


def _message(joints: tuple[str, ...], given: tuple[bool, bool, bool]) -> bytes:
    """Return a message of zeros with these arrays, little-endian."""
    message = bytearray(b"\0\1\0\0" + bytes(8))  # the encapsulation and the time stamp

    def align(size: int) -> None:
        message.extend(bytes((_HEADER - len(message)) % size))

    def count(number: int) -> None:
        align(4)
        message.extend(struct.pack("<I", number))

    def text(content: str) -> None:
        data = content.encode() + b"\0"
        count(len(data))
        message.extend(data)

    text("")  # frame_id
    count(len(joints))
    for joint in joints:
        text(joint)
    for filled in given:
        count(len(joints) if filled else 0)
        if filled and joints:
            align(8)
            message.extend(bytes(8 * len(joints)))
    return bytes(message)


def _as_bytes(values: "Ints | Floats", kind: str) -> Bytes:
    converted = np.ascontiguousarray(values, dtype=kind)
    return converted.view(np.uint8).reshape(len(values), -1)
