"""Looking into a serialised JointState without building a message object.

A Python JointState costs 0.1 to 0.2 ms to deserialise, too much to do 500 times a second beside
a paced loop; this costs a few µs, because the names come the same every time.
"""

import struct
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lagrangian_ff.nodes.common.errors import MessageError

Floats = NDArray[np.float64]

ENCAPSULATION = 4
STAMP_END = ENCAPSULATION + 8


@dataclass(frozen=True)
class JointStateView:
    """A JointState as it came: stamp in ns, names, and arrays that may be empty or hold NaN."""

    stamp: int
    names: tuple[str, ...]
    position: Floats
    velocity: Floats
    effort: Floats

    def fault(self) -> str | None:
        """What makes this message unusable, in words; None where it can be used.

        Velocity and effort may be empty or NaN: many drivers do not measure them.
        """
        if not self.names:
            return "a joint state without names"
        if len(set(self.names)) != len(self.names):
            return f"a joint state that names a joint twice: {', '.join(self.names)}"
        expected = len(self.names)
        if len(self.position) != expected:
            return f"a joint state with {len(self.position)} positions for {expected} names"
        for label, values in (("velocities", self.velocity), ("efforts", self.effort)):
            if len(values) not in (0, expected):
                return f"a joint state with {len(values)} {label} for {expected} names"
        finite = np.isfinite(self.position)
        if not finite.all():
            return f"a joint state where the position of {self.names[int(finite.argmin())]} is NaN"
        return None


class JointStateReader:
    """Reads JointState messages in CDR, quickly where the names do not change."""

    def __init__(self) -> None:
        self._header = b""
        self._names: tuple[str, ...] = ()
        self._order = "<"

    def read(self, data: bytes) -> JointStateView:
        """What the bytes say.

        Raises:
            MessageError: they are not a JointState in plain CDR.
        """
        try:
            header = self._header
            same = len(header) > 0 and data[STAMP_END : STAMP_END + len(header)] == header
            if not same or data[1] != (1 if self._order == "<" else 0):
                self._learn(data)
            return self._view(data)
        except (struct.error, ValueError, IndexError) as error:
            raise MessageError(
                f"{len(data)} bytes that are not a sensor_msgs/JointState ({error})"
            ) from None

    def _learn(self, data: bytes) -> None:
        self._header = b""
        if data[0] != 0 or data[1] not in (0, 1):
            raise ValueError("not plain CDR")
        self._order = "<" if data[1] == 1 else ">"
        _, at = self._text(data, STAMP_END)
        count, at = self._number(data, at)
        if count > len(data):
            raise ValueError(f"{count} names")
        names = []
        for _ in range(count):
            name, at = self._text(data, at)
            names.append(name)
        self._names = tuple(names)
        self._header = data[STAMP_END:at]

    def _number(self, data: bytes, at: int) -> tuple[int, int]:
        at += -(at - ENCAPSULATION) % 4
        return struct.unpack_from(f"{self._order}I", data, at)[0], at + 4

    def _text(self, data: bytes, at: int) -> tuple[str, int]:
        length, at = self._number(data, at)
        if at + length > len(data):
            raise ValueError("cut off in a text")
        return data[at : at + max(length - 1, 0)].decode(), at + length

    def _view(self, data: bytes) -> JointStateView:
        seconds, nanoseconds = struct.unpack_from(f"{self._order}iI", data, ENCAPSULATION)
        at = STAMP_END + len(self._header)
        arrays = []
        for _ in range(3):
            count, at = self._number(data, at)
            if count:
                at += -(at - ENCAPSULATION) % 8
            arrays.append(np.frombuffer(data, f"{self._order}f8", count, at))
            at += 8 * count
        return JointStateView(seconds * 1_000_000_000 + nanoseconds, self._names, *arrays)
