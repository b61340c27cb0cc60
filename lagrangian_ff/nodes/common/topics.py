"""Topics: quality of service, subscriptions for paced loops, messages to and from arrays."""

import struct
from array import array
from collections.abc import Iterator
from typing import Any

import numpy as np
from builtin_interfaces.msg import Duration, Time
from rclpy.callback_groups import CallbackGroup
from rclpy.exceptions import InvalidHandle
from rclpy.impl.implementation_singleton import rclpy_implementation
from rclpy.node import Node
from rclpy.publisher import Publisher
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from rclpy.qos_overriding_options import QoSOverridingOptions
from std_msgs.msg import Float64MultiArray
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

from lagrangian_ff.arm.trajectory import Trajectory
from lagrangian_ff.arrays import Floats
from lagrangian_ff.nodes.streaming.reference import Points, Reference

BEST_EFFORT, SAFE = ReliabilityPolicy.BEST_EFFORT, ReliabilityPolicy.RELIABLE
# A best-effort subscription matches reliable and best-effort publishers alike.
RECORDING = QoSProfile(depth=5000, reliability=BEST_EFFORT)
NEWEST = QoSProfile(depth=1, reliability=BEST_EFFORT)
# Several parts of a robot may publish on one topic, each its own joints.
SHARED = QoSProfile(depth=50, reliability=BEST_EFFORT)
CLOCK = QoSProfile(depth=1, reliability=BEST_EFFORT)
RELIABLE = QoSProfile(depth=10, reliability=SAFE)
# A tenth of a second of set-points at 1 kHz.
REFERENCES = QoSProfile(depth=100, reliability=SAFE)
# Deep, because an arm that was delayed publishes many samples at once.
STATES = QoSProfile(depth=2000, reliability=SAFE)
LATCHED = QoSProfile(depth=1, reliability=SAFE, durability=DurabilityPolicy.TRANSIENT_LOCAL)


def overridable() -> QoSOverridingOptions:
    """Let parameters `qos_overrides.<topic>.<publisher|subscription>.*` change the profile."""
    return QoSOverridingOptions.with_default_policies()


def advertise(node: Node, kind: type, topic: str, profile: QoSProfile) -> Publisher:
    """Return a publisher whose profile is overridable."""
    return node.create_publisher(kind, topic, profile, qos_overriding_options=overridable())


class _NotForTheExecutor(CallbackGroup):
    """Keeps its entities out of every wait set."""

    def can_execute(self, entity: object) -> bool:
        return False

    def beginning_execution(self, entity: object) -> bool:
        return False

    def ending_execution(self, entity: object) -> None:
        pass


class PolledSubscription:
    """A subscription that one thread of its owner reads, past the executor.

    rclpy's executor rebuilds its wait set for every message: 0.3 ms at 500 Hz beside a node's
    services, a sixth of a core. A paced loop that takes the waiting messages needs a few µs each,
    and finds the newest command at the very tick that uses it.

    Args:
        topic: may be relative or private.
        profile: its depth bounds the messages that can wait.
        raw: whether messages are left serialised.
    """

    def __init__(
        self, node: Node, kind: type, topic: str, profile: QoSProfile, *, raw: bool = False
    ) -> None:
        self._node = node
        # The node keeps only a weak reference to the group.
        self._group = _NotForTheExecutor()
        self._subscription = node.create_subscription(
            kind,
            topic,
            lambda message: None,
            profile,
            callback_group=self._group,
            raw=raw,
            qos_overriding_options=overridable(),
        )
        self._waiting = rclpy_implementation.WaitSet(1, 0, 0, 0, 0, 0, node.context.handle)

    @property
    def topic(self) -> str:
        """Return the full name of the topic."""
        return str(self._subscription.topic_name)

    def wait(self, seconds: float) -> None:
        """Return as soon as a message waits, or after this time."""
        handle = self._subscription.handle
        try:
            with handle:
                self._waiting.clear_entities()
                self._waiting.add_subscription(handle)
                self._waiting.wait(round(seconds * 1e9))
        except InvalidHandle:  # destroyed
            return

    def take(self) -> Iterator[tuple[Any, int]]:
        """Yield the waiting messages, oldest first, each with its time of reception in ns."""
        handle = self._subscription.handle
        while True:
            try:
                with handle:
                    found = handle.take_message(self._subscription.msg_type, self._subscription.raw)
            except InvalidHandle:  # destroyed
                return
            if found is None:
                return
            message, information = found
            yield message, int(information["received_timestamp"])

    def destroy(self) -> None:
        """Unsubscribe."""
        self._node.destroy_subscription(self._subscription)


def nanoseconds(stamp: Time | Duration) -> int:
    """Return the ns of a stamp or a duration."""
    return int(stamp.sec) * 1_000_000_000 + int(stamp.nanosec)


def stamp(at: int) -> Time:
    """Return the stamp of a time in ns."""
    return Time(sec=at // 1_000_000_000, nanosec=at % 1_000_000_000)


def message_of(trajectory: Trajectory, start: int) -> JointTrajectory:
    """Return a trajectory without its effort as a message; `start` in ns, 0 for the receiver's."""
    message = JointTrajectory(joint_names=list(trajectory.joints))
    message.header.stamp = stamp(start)
    for k in range(len(trajectory)):
        at = round((trajectory.time[k] - trajectory.time[0]) * 1e9)
        point = JointTrajectoryPoint(
            positions=trajectory.q[k].tolist(),
            velocities=trajectory.qd[k].tolist(),
            accelerations=trajectory.qdd[k].tolist(),
        )
        point.time_from_start.sec, point.time_from_start.nanosec = divmod(at, 1_000_000_000)
        message.points.append(point)
    return message


def points(message: JointTrajectory) -> Points:
    """Return the content of a trajectory message, unchecked."""
    return Points(
        names=list(message.joint_names),
        time=[p.time_from_start.sec + p.time_from_start.nanosec / 1e9 for p in message.points],
        position=[p.positions for p in message.points],
        velocity=[p.velocities for p in message.points],
        acceleration=[p.accelerations for p in message.points],
        effort=[p.effort for p in message.points],
    )


def count_points(data: bytes) -> int:
    """Return the number of points of a serialised trajectory; 0 if it is none.

    Deserialising holds up every thread of the process: 100,000 points for half a second.
    """
    order, at = "<" if data[1:2] == b"\x01" else ">", 12  # behind encapsulation and stamp

    def number() -> int:
        nonlocal at
        at = (at + 3) // 4 * 4 + 4
        return int(struct.unpack_from(f"{order}I", data, at - 4)[0])

    def skip_text() -> None:
        nonlocal at
        length = number()
        at += length

    try:
        skip_text()  # frame_id
        for _ in range(min(number(), len(data))):  # joint_names
            skip_text()
        return number()
    except struct.error:
        return 0


def annotated(
    message: JointTrajectory, joints: tuple[str, ...], effort: Floats, start: int
) -> JointTrajectory:
    """Fill the effort (K, N) N·m of N joints and the start, ns, into a message and return it.

    The message itself changes; joints without a torque get zero.
    """
    columns = [message.joint_names.index(joint) for joint in joints]
    row = np.zeros(len(message.joint_names))
    for point, tau in zip(message.points, effort, strict=True):
        row[columns] = tau
        point.effort = _doubles(row)
    message.header.stamp = stamp(start)
    return message


def resampled(
    message: JointTrajectory, path: Reference, time: Floats, joints: tuple[str, ...], effort: Floats
) -> JointTrajectory:
    """Return a trajectory with points at more times and the effort in each.

    The message's own points stay as they are; the others lie on its path, and have what they have:
    positions, velocities, accelerations. Joints without a torque get zero.

    Args:
        path: through the message's points, of all its joints in its order.
        time: (M,) s, the times of the message's points among them.
        joints, effort: N names and (M, N) N·m.
    """
    given = {nanoseconds(point.time_from_start): point for point in message.points}
    columns = [message.joint_names.index(joint) for joint in joints]
    row = np.zeros(len(message.joint_names))
    found = JointTrajectory(header=message.header, joint_names=message.joint_names)
    for at, q, qd, qdd, tau in zip(time, *path.sample(time), effort, strict=True):
        row[columns] = tau
        since = round(at * 1e9)
        own = given.get(since)
        seconds, rest = divmod(since, 1_000_000_000)
        found.points.append(
            JointTrajectoryPoint(
                positions=own.positions if own else _doubles(q),
                velocities=own.velocities if own else _doubles(qd if path.degree >= 3 else q[:0]),
                accelerations=own.accelerations
                if own
                else _doubles(qdd if path.degree == 5 else q[:0]),
                effort=_doubles(row),
                time_from_start=Duration(sec=seconds, nanosec=rest),
            )
        )
    return found


def command(tau: Floats) -> Float64MultiArray:
    """Return the message of a command; zero replaces what is not finite."""
    return Float64MultiArray(data=_doubles(np.where(np.isfinite(tau), tau, 0.0)))


def _doubles(values: Floats) -> "array[float]":
    # The setters check every element of what is not an array already.
    return array("d", np.ascontiguousarray(values, dtype=np.float64).tobytes())
