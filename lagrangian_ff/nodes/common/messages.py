"""Between messages and arrays."""

from array import array

import numpy as np
from builtin_interfaces.msg import Time
from numpy.typing import NDArray
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64MultiArray
from trajectory_msgs.msg import JointTrajectory

from lagrangian_ff.nodes.streaming.reference import Points

Floats = NDArray[np.float64]


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
    """Fills one message again and again: building a new one costs more than publishing it."""

    def __init__(self, joints: tuple[str, ...]) -> None:
        self._message = JointState(name=list(joints))

    def fill(self, at: int, position: Floats, velocity: Floats, effort: Floats) -> JointState:
        """The message of this instant; valid until the next call.

        Args:
            at: ns.
            position: (N,) rad.  velocity: (N,) rad/s.  effort: (N,) N·m.
        """
        message = self._message
        message.header.stamp = stamp(at)
        message.position = _doubles(position)
        message.velocity = _doubles(velocity)
        message.effort = _doubles(effort)
        return message


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
