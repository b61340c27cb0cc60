"""An arm of two joints that a script moves, in a ROS graph: a driver without physics of its own."""

import threading
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import Any

import numpy as np
import rclpy
from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from sensor_msgs.msg import JointState
from trajectory_msgs.msg import JointTrajectory

from lagrangian_ff.arm.trajectory import Trajectory
from lagrangian_ff.arrays import Floats
from lagrangian_ff.nodes.common.topics import RELIABLE, PolledSubscription, nanoseconds, stamp

JOINTS = ("a", "b")
TOPIC = "/driver/joint_trajectory"
HZ = 250.0


def motion_at(at: float) -> tuple[Floats, Floats, Floats]:
    """Return q, qd and qdd, (2,) each, at a time in s: the motion of `small_model`."""
    q, qd, qdd = (np.zeros(2) for _ in range(3))
    for amplitude, speed in ((0.5, (1.1, 1.7)), (0.4, (3.1, 3.7))):
        w = np.array(speed)
        q += amplitude * np.sin(w * at)
        qd += amplitude * w * np.cos(w * at)
        qdd -= amplitude * w**2 * np.sin(w * at)
    return q, qd, qdd


class Driver(threading.Thread):
    """A scripted arm: publishes joint states, and follows the trajectories that it takes.

    Attributes:
        moving: whether it makes its own motion.
        silent: whether it publishes nothing.
        refusals: how many of the trajectories after the first it refuses.
        deaf: whether it takes trajectories without following them.
        hasty: whether it begins each when it comes, whatever its stamp says.
        q: (2,) rad, where it is.  velocity: (2,) rad/s.
        jump: rad, the widest step from one sample to the next.
        came: the trajectories.
    """

    def __init__(self, node: Node, drag: float = 0.0) -> None:
        super().__init__(daemon=True)
        self._states = node.create_publisher(JointState, "joint_states", 100)
        self._drag = drag
        self.moving, self.silent, self.deaf, self.hasty = True, False, False, False
        self.refusals = 0
        self.came: list[JointTrajectory] = []
        self.jump = 0.0
        self._followed: tuple[float, Any] | None = None
        self.q, self.velocity = np.zeros(2), np.zeros(2)
        self._end = threading.Event()
        self._taken = PolledSubscription(node, JointTrajectory, TOPIC, RELIABLE)

    def run(self) -> None:
        began, epoch = time.monotonic(), time.time_ns()
        now = began
        while not self._end.is_set():
            now += 1.0 / HZ  # no sample is left out where the processor was busy
            time.sleep(max(0.0, now - time.monotonic()))
            for came, _ in self._taken.take():
                self.came.append(came)
                if self.refusals > 0 and len(self.came) > 1:
                    self.refusals -= 1
                else:
                    begins = nanoseconds(came.header.stamp)
                    since = began + (begins - epoch) / 1e9 if begins and not self.hasty else now
                    self._followed = None if self.deaf else (since, path_of(came))
            q, qd, qdd = motion_at(now - began)
            if not self.moving:
                q, qd, qdd = self.q, np.zeros(2), np.zeros(2)
                if self._followed is not None:
                    since, path = self._followed
                    q, qd, qdd = path.sample(now - since)
            self.jump = max(self.jump, float(np.abs(q - self.q).max()))
            self.q, self.velocity = q, qd
            tau = 8.0 * np.cos(q) + 1.5 * qdd + 0.4 * qd + np.tanh(qd / 0.02)
            tau[1] += self._drag * qd[1] * abs(qd[1])
            message = JointState(
                name=list(JOINTS), position=q.tolist(), velocity=qd.tolist(), effort=tau.tolist()
            )
            message.header.stamp = stamp(epoch + round((now - began) * 1e9))
            if not self.silent:
                self._states.publish(message)

    def end(self) -> None:
        self._end.set()
        self.join(5.0)


def path_of(message: JointTrajectory) -> Trajectory:
    """Return the trajectory in a message."""
    time_ = [p.time_from_start.sec + p.time_from_start.nanosec / 1e9 for p in message.points]
    q, qd, qdd = (
        np.array([getattr(p, name) for p in message.points])
        for name in ("positions", "velocities", "accelerations")
    )
    return Trajectory(np.array(time_), q, qd, qdd, tuple(message.joint_names))


@contextmanager
def driving(drag: float, *, moving: bool = True, takes: Sequence[str] = ()) -> Iterator[Driver]:
    """Yield the scripted arm in its own node, from its start to its end.

    Args:
        takes: its parameter `joints`, as ros2_control's controllers have it; empty for none.
    """
    context = Context()
    rclpy.init(context=context)
    node = rclpy.create_node("driver", context=context)
    if takes:
        node.declare_parameter("joints", list(takes))
    executor = SingleThreadedExecutor(context=context)
    executor.add_node(node)
    spinning = threading.Thread(target=executor.spin, daemon=True)
    spinning.start()
    made = Driver(node, drag)
    made.moving = moving
    made.start()
    try:
        yield made
    finally:
        made.end()
        executor.shutdown()
        spinning.join(5.0)
        node.destroy_node()
        context.try_shutdown()
