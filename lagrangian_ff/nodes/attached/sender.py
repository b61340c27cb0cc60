"""Sends motions to whoever takes trajectories, and stops them."""

import threading
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from rclpy.duration import Duration
from rclpy.node import Node
from rclpy.publisher import Publisher
from trajectory_msgs.msg import JointTrajectory

from lagrangian_ff.arm.trajectory import read_trajectory
from lagrangian_ff.arrays import Floats
from lagrangian_ff.errors import UserError
from lagrangian_ff.nodes.attached.motions import Plan, held, plan, slowed
from lagrangian_ff.nodes.attached.poses import Poses
from lagrangian_ff.nodes.common.topics import RELIABLE, message_of

TAKES = "trajectory_msgs/msg/JointTrajectory"
MOVED = 0.02  # rad by which the arm may have moved since a motion was prepared
AFTER = 0.3  # s after its last point in which a motion ends
NEAR = 0.2  # rad from a motion at which it still counts as followed
PATIENCE = 2.0  # s until a publisher has found its subscribers
DELIVERED = 1.0  # s in which a message reaches them


@dataclass(frozen=True)
class Prepared:
    """A motion that can be sent as it is: what is sent is what was confirmed.

    Attributes:
        number: that of the request.
        topic: where to.
        nodes: who listens there.
        plan: what is sent.
    """

    number: int
    topic: str
    nodes: tuple[str, ...]
    plan: Plan


@dataclass(frozen=True)
class Sent:
    """A motion under way.

    Attributes:
        prepared: what was sent.
        at: ns, the newest stamp of the joint states when it was sent.
        steady: s of the monotonic clock then.
    """

    prepared: Prepared
    at: int
    steady: float


class Sender:
    """Sends one motion at a time.

    One thread prepares, sends and stops; others may ask what goes on, and never wait.

    Args:
        node: publishes.
        poses: of the arm.
        warn: receives the kind and the text of a warning.
    """

    def __init__(self, node: Node, poses: Poses, warn: Callable[[str, str], None]) -> None:
        self._node, self._poses, self._warn = node, poses, warn
        self._publishers: dict[str, Publisher] = {}
        self._prepared: Prepared | None = None
        self._sent: Sent | None = None
        self._astray = 0
        self._lock = threading.RLock()

    def topics(self) -> list[dict[str, Any]]:
        """Return the topics in the graph that somebody takes trajectories from, and who."""
        found = []
        for topic, kinds in self._node.get_topic_names_and_types():
            if TAKES in kinds and (nodes := self._listeners(topic)):
                found.append({"topic": topic, "nodes": list(nodes), "subscribers": len(nodes)})
        return found

    def prepare(self, number: int, file: str, topic: str) -> dict[str, Any]:
        """Return what would happen if the motion in a file was sent now; nothing is sent.

        Raises:
            UserError: it cannot be sent.
        """
        motion = read_trajectory(file)
        with self._lock:
            self._prepared = None
            if self.running() is not None:
                raise UserError("a motion is under way: wait for its end, or stop it")
            nodes = self._listeners(topic)
            if not nodes:
                raise UserError(f"nobody takes trajectories from {topic}")
            made = plan(motion, self._poses.standing(motion.joints))
            self._publisher(topic)  # it has found its subscribers until the motion is confirmed
            self._prepared = Prepared(number, topic, nodes, made)
        return {
            "topic": topic,
            "nodes": list(nodes),
            "joints": list(motion.joints),
            "seconds": made.trajectory.duration,
            "way": made.way,
            "start": motion.q[0].tolist(),
            "moved": made.moved.tolist(),
            "fastest": made.fastest.tolist(),
            "notes": list(motion.notes),
        }

    def send(self, number: int) -> dict[str, Any]:
        """Send the motion that was prepared last, and return how long it takes.

        Raises:
            UserError: it is not the one of this number, or something has changed since.
        """
        with self._lock:
            prepared, self._prepared = self._prepared, None
            if prepared is None or prepared.number != number:
                raise UserError("this motion is not the one that was prepared last: look again")
            if self.running() is not None:
                raise UserError("a motion is under way: wait for its end, or stop it")
        trajectory = prepared.plan.trajectory
        message, publisher = message_of(trajectory, 0), self._publisher(prepared.topic)
        end = time.monotonic() + PATIENCE
        while publisher.get_subscription_count() < len(prepared.nodes):
            if time.monotonic() > end:
                raise UserError(f"{prepared.topic} is not connected: look again")
            time.sleep(0.02)
        if self._listeners(prepared.topic) != prepared.nodes:
            raise UserError(f"other nodes listen on {prepared.topic} now: look again")
        if np.abs(self._poses.standing(trajectory.joints) - trajectory.q[0]).max() > MOVED:
            raise UserError("the arm has moved since the motion was prepared: look again")
        with self._lock:
            publisher.publish(message)
            self._sent, self._astray = Sent(prepared, self._poses.at, time.monotonic()), 0
        return {"seconds": trajectory.duration}

    def stop(self) -> dict[str, Any]:
        """Bring the motion under way to rest: on its path, or where the arm is if it left that.

        Raises:
            UserError: there is none.
        """
        with self._lock:
            sent = self._sent
            if sent is None:
                raise UserError("no motion is under way")
            self._sent = None
            trajectory = sent.prepared.plan.trajectory
            rest = slowed(trajectory, self._elapsed(sent))
            q, away = self._away(sent)
            if q is not None and away.max() > NEAR:
                rest = held(trajectory.joints, q)
        publisher = self._publisher(sent.prepared.topic)
        publisher.publish(message_of(rest, 0))
        publisher.wait_for_all_acked(Duration(seconds=DELIVERED))
        return {"seconds": rest.duration}

    def running(self) -> dict[str, Any] | None:
        """Return the motion under way, None without one."""
        with self._lock:
            sent = self._sent
            if sent is None:
                return None
            elapsed, seconds = self._elapsed(sent), sent.prepared.plan.trajectory.duration
            if elapsed > seconds + AFTER:
                self._sent = None
                return None
            return {"topic": sent.prepared.topic, "elapsed": elapsed, "seconds": seconds}

    def look(self) -> None:
        """Warn if the arm does not follow; to be called twice a second."""
        with self._lock:
            sent = self._sent
            if sent is None:
                return
            _, away = self._away(sent)
            self._astray = self._astray + 1 if away.max() > NEAR else 0
            if self._astray > 1:
                joint = sent.prepared.plan.trajectory.joints[int(away.argmax())]
                self._warn(
                    "not followed",
                    f"the arm does not follow the motion: {joint} is {away.max():.2g} rad off; "
                    f"the log of {', '.join(sent.prepared.nodes)} may say why",
                )

    def _away(self, sent: Sent) -> tuple[Floats | None, Floats]:
        """Return the pose (N,) rad and its distance from the motion; no pose if it is not known."""
        trajectory = sent.prepared.plan.trajectory
        try:
            q = self._poses.now(trajectory.joints)
        except UserError:
            return None, np.zeros(len(trajectory.joints))
        return q, np.abs(q - trajectory.sample(self._elapsed(sent))[0])

    def _elapsed(self, sent: Sent) -> float:
        """Return the s since a motion was sent: of the robot's clock while that is heard."""
        if self._poses.at > sent.at and self._poses.joints:
            return (self._poses.at - sent.at) / 1e9
        return time.monotonic() - sent.steady

    def _listeners(self, topic: str) -> tuple[str, ...]:
        """Return the full names of the nodes that subscribe, sorted."""
        try:
            found = self._node.get_subscriptions_info_by_topic(topic)
        except ValueError as error:
            raise UserError(f"{topic!r} is no topic: {error}") from error
        mine = (one for one in found if one.topic_type == TAKES)
        return tuple(sorted(f"{one.node_namespace.rstrip('/')}/{one.node_name}" for one in mine))

    def _publisher(self, topic: str) -> Publisher:
        if topic not in self._publishers:
            made = self._node.create_publisher(JointTrajectory, topic, RELIABLE)
            self._publishers[topic] = made
        return self._publishers[topic]
