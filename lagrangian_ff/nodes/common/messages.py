"""Between messages and arrays."""

from array import array
from struct import Struct

import numpy as np
from builtin_interfaces.msg import Time
from numpy.typing import NDArray
from std_msgs.msg import Float64MultiArray
from trajectory_msgs.msg import JointTrajectory

from lagrangian_ff.nodes.common.joint_state_bytes import STAMP
from lagrangian_ff.nodes.streaming.reference import Points
from lagrangian_ff.recording.joint_state import JointStateEncoder, read_layout

Floats = NDArray[np.float64]

_STAMP = Struct("<iI")


def nanoseconds(stamp: Time) -> int:
    """Ns of a stamp."""
    return int(stamp.sec) * 1_000_000_000 + int(stamp.nanosec)


def stamp(at: int) -> Time:
    """The stamp of a time in ns."""
    return Time(sec=at // 1_000_000_000, nanosec=at % 1_000_000_000)


def points(message: JointTrajectory) -> Points:
    """What a trajectory message says, unchecked."""
    return Points(
        names=list(message.joint_names),
        time=[p.time_from_start.sec + p.time_from_start.nanosec / 1e9 for p in message.points],
        position=[p.positions for p in message.points],
        velocity=[p.velocities for p in message.points],
        acceleration=[p.accelerations for p in message.points],
        effort=[p.effort for p in message.points],
    )


class JointStateMaker:
    """Fills one serialised JointState again and again.

    To build a message object and have rclpy serialise it costs several times as much as publishing
    it.
    """

    def __init__(self, joints: tuple[str, ...]) -> None:
        still = np.zeros((1, len(joints)))
        message = JointStateEncoder(joints).encode(np.zeros(1, np.int64), still, still, still)[0]
        self._data = bytearray(message)
        self._starts = read_layout(message).start

    def fill(self, at: int, position: Floats, velocity: Floats, effort: Floats) -> bytes:
        """The message of this instant, for `Publisher.publish`.

        Args:
            at: ns.
            position: (N,) rad.  velocity: (N,) rad/s.  effort: (N,) N·m.
        """
        data = self._data
        _STAMP.pack_into(data, STAMP, *divmod(at, 1_000_000_000))
        for start, values in zip(self._starts, (position, velocity, effort), strict=True):
            written = np.asarray(values, dtype="<f8").tobytes()
            data[start : start + len(written)] = written
        return bytes(data)


def _doubles(values: Floats) -> "array[float]":
    # The setters check element by element whatever is not an array already.
    return array("d", np.ascontiguousarray(values, dtype=np.float64).tobytes())


def annotated(
    message: JointTrajectory, joints: tuple[str, ...], effort: Floats, start: int
) -> JointTrajectory:
    """The same message with effort and start filled in; joints without a torque get zero.

    Args:
        message: K points; it is changed.
        joints: N names in it.
        effort: (K, N) N·m.
        start: ns.
    """
    columns = [message.joint_names.index(joint) for joint in joints]
    row = np.zeros(len(message.joint_names))
    for point, tau in zip(message.points, effort, strict=True):
        row[columns] = tau
        point.effort = _doubles(row)
    message.header.stamp = stamp(start)
    return message


def command(tau: Floats) -> Float64MultiArray:
    """A command that is never NaN: what is not finite is zero."""
    return Float64MultiArray(data=_doubles(np.where(np.isfinite(tau), tau, 0.0)))
