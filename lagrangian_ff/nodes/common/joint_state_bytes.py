"""Serialised JointState messages, read and written without a message object.

rclpy takes 0.1 to 0.2 ms to deserialise one, too much 500 times a second beside a paced loop;
this takes a few µs, because the layout is the same every time.
"""

import struct
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from lagrangian_ff.arrays import Floats
from lagrangian_ff.errors import UserError
from lagrangian_ff.recording.joint_state import (
    JointStateEncoder,
    Layout,
    MalformedError,
    read_layout,
)

STAMP = 4  # offset of header.stamp, behind the encapsulation header


class MessageError(UserError):
    """A message with impossible content: wrong lengths, NaN, unknown joints."""


@dataclass(frozen=True)
class JointStateView:
    """A received JointState.

    Attributes:
        stamp: ns of header.stamp.
        names: N joints.
        position, velocity, effort: (N,), or empty; may hold NaN.
    """

    stamp: int
    names: tuple[str, ...]
    position: Floats
    velocity: Floats
    effort: Floats

    def columns(self, joints: Sequence[str]) -> list[int]:
        """Return the index of each joint; an empty list if the message has none of them.

        Raises:
            MessageError: some of them are missing.
        """
        missing = [joint for joint in joints if joint not in self.names]
        if len(missing) == len(joints):
            return []
        if missing:
            raise MessageError(f"joint states without {', '.join(missing)}")
        return [self.names.index(joint) for joint in joints]

    def fault(self) -> str:
        """Return why the positions cannot be used; empty if they can.

        Velocity and effort may be missing: many drivers do not measure them.
        """
        if len(self.position) == 0:
            return f"a joint state of {', '.join(self.names)} without positions"
        finite = np.isfinite(self.position)
        if not finite.all():
            name = self.names[int(finite.argmin())]
            return f"a joint state where the position of {name} is not finite"
        return ""


class JointStateReader:
    """Reads serialised JointState messages, quickly while their layout does not change."""

    def __init__(self) -> None:
        self._layout: Layout | None = None
        self._fixed = b""

    def read(self, data: bytes) -> JointStateView:
        """Return the content of a message.

        Raises:
            MessageError: they are not a JointState, or one without names, with a name twice
                or with arrays of another length than the names.
        """
        layout = self._layout
        if layout is None or len(layout.fixed) != len(data) or self._key(data) != self._fixed:
            try:
                layout = read_layout(data)
            except MalformedError as error:
                raise MessageError(f"a joint state of {len(data)} bytes: {error}") from None
            self._layout = layout
            self._fixed = self._key(data)
        seconds, nanoseconds = struct.unpack_from(f"{layout.order}iI", data, STAMP)
        count = len(layout.names)
        position, velocity, effort = (
            np.frombuffer(data, f"{layout.order}f8", count if start >= 0 else 0, max(start, 0))
            for start in layout.start
        )
        at = seconds * 1_000_000_000 + nanoseconds
        return JointStateView(at, layout.names, position, velocity, effort)

    def _key(self, data: bytes) -> bytes:
        """Return the bytes that messages of this layout share."""
        assert self._layout is not None
        return np.frombuffer(data, np.uint8)[self._layout.fixed].tobytes()


class JointStateMaker:
    """Fills one serialised JointState again and again, in rad, rad/s and N·m.

    Building a message object and letting rclpy serialise it takes several times as long as
    publishing it.
    """

    def __init__(self, joints: tuple[str, ...]) -> None:
        still = np.zeros((1, len(joints)))
        message = JointStateEncoder(joints).encode(np.zeros(1, np.int64), still, still, still)[0]
        self._data = bytearray(message)
        self._starts = read_layout(message).start

    def fill(self, at: int, position: Floats, velocity: Floats, effort: Floats) -> bytes:
        """Return the message of an instant (ns), for `Publisher.publish`; the others are (N,)."""
        data = self._data
        struct.pack_into("<iI", data, STAMP, *divmod(at, 1_000_000_000))
        for start, values in zip(self._starts, (position, velocity, effort), strict=True):
            written = np.asarray(values, dtype="<f8").tobytes()
            data[start : start + len(written)] = written
        return bytes(data)
