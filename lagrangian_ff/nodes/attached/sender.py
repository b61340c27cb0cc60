"""Sends motions to whoever takes trajectories, and stops them."""

import math
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from rclpy.node import Node
from rclpy.publisher import Publisher
from trajectory_msgs.msg import JointTrajectory

from lagrangian_ff.arm.trajectory import Trajectory, read_trajectory
from lagrangian_ff.arrays import Floats
from lagrangian_ff.errors import UserError
from lagrangian_ff.nodes.attached.controllers import joints_parameter
from lagrangian_ff.nodes.attached.following import EARLY, NEAR, Seen
from lagrangian_ff.nodes.attached.motions import Plan, held, plan, slowed
from lagrangian_ff.nodes.attached.poses import STANDING, Poses
from lagrangian_ff.nodes.common.topics import RELIABLE, message_of, stamp

TAKES = "trajectory_msgs/msg/JointTrajectory"
UNKNOWN = "_NODE_NAME_UNKNOWN_"
MOVED = 0.02  # rad by which the arm may have moved since a motion was prepared
AFTER = 0.3  # s after its last point in which a motion ends
PATIENCE = 2.0  # s until a publisher has found its subscribers
SOON = 0.5  # s until a motion begins
AHEAD = 0.1  # s until a stop begins
SAME = 0.5  # s that the clock of the joint states may differ from ours
LEADS = (0.03, 0.0, 0.06, 0.1)
"""s on the path by which the tries of a stop begin ahead where the clocks differ."""
LOOKED = 0.1  # s over which it is seen whether the arm stands
LOOKS = 6
"""Looks within which a motion and its stop must come apart: else both rest."""
STILL = 0.3
"""Share of the motion's own movement below which the arm has come to rest."""
APART = 0.02  # rad between a motion and its stop below which it does not show which one goes on
CALM = 3.0  # s after an alarm in which no motion is sent


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
        at: ns, the stamp of its start, on the clock of the joint states.
        steady: s of the monotonic clock then.
        at_once: whether the arm ignores stamps and begins what it is sent when it comes.
        seen: of the arm since.
    """

    prepared: Prepared
    at: int
    steady: float
    at_once: bool = False
    seen: Seen = field(default_factory=Seen)


class Sender:
    """Sends one motion at a time.

    One thread prepares, sends and stops; others may ask what goes on or raise the alarm, and never
    wait.

    Args:
        node: publishes.
        poses: of the arm.
        warn: receives the kind and the text of a warning.

    Attributes:
        alarm: why the last motion was stopped without being asked to; empty if it was not.
    """

    def __init__(self, node: Node, poses: Poses, warn: Callable[[str, str], None]) -> None:
        self._node, self._poses, self._warn = node, poses, warn
        self._publishers: dict[str, Publisher] = {}
        self._prepared: Prepared | None = None
        self._sent: Sent | None = None
        self._at_once: set[str] = set()
        self.alarm = ""
        self._alarmed = -math.inf, ""
        self._lock = threading.RLock()
        self._stopping = threading.Lock()

    def topics(self) -> list[dict[str, Any]]:
        """Return the topics in the graph that somebody takes trajectories from, and who."""
        found = []
        for topic, kinds in self._node.get_topic_names_and_types():
            if TAKES in kinds and (nodes := self._listeners(topic)):
                found.append({"topic": topic, "nodes": list(nodes), "subscribers": len(nodes)})
        return found

    def takes(self, topic: str) -> list[str]:
        """Return the joints that who takes trajectories from a topic has; none if nobody says."""
        for name in self._listeners(topic):
            if found := joints_parameter(self._node, name):
                return found
        return []

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
        publisher = self._connected(prepared)
        if self._listeners(prepared.topic) != prepared.nodes:
            raise UserError(f"other nodes listen on {prepared.topic} now: look again")
        if np.abs(self._poses.standing(trajectory.joints) - trajectory.q[0]).max() > MOVED:
            raise UserError("the arm has moved since the motion was prepared: look again")
        message, at = message_of(trajectory, 0), self._poses.at
        at_once = prepared.topic in self._at_once
        begins = 0 if at_once else self._start(SOON)
        message.header.stamp = stamp(begins)
        later = SOON if begins else 0.0
        with self._lock:
            since, words = self._alarmed
            if time.monotonic() < since + CALM:
                raise UserError(f"{words}: no motion is sent until that has been over for a while")
            publisher.publish(message)
            self._sent = Sent(prepared, begins or at, time.monotonic() + later, at_once)
            self.alarm = ""
            at = self._sent.at
        return {"seconds": trajectory.duration, "at": at, "from": trajectory.q[0].tolist()}

    def adopt(self, file: str, topic: str, begin: Floats, at: int) -> dict[str, Any]:
        """Take over a motion that a process sent which has died since, to stop it.

        Args:
            begin: (N,) rad, where its way to the start began.
            at: ns, the stamp of its start.

        Raises:
            UserError: the joint states are not heard, or nobody listens on the topic.
        """
        made = plan(read_trajectory(file), begin)
        self._poses.now(made.trajectory.joints)
        prepared = Prepared(0, topic, self._listeners(topic), made)
        if not prepared.nodes:
            raise UserError(f"nobody takes trajectories from {topic}")
        self._connected(prepared)
        with self._lock:
            since = (self._poses.at - at) / 1e9
            self._sent = Sent(prepared, at, time.monotonic() - since)
        return {"motion": self.running()}

    def raise_alarm(self, words: str) -> None:
        """Stop the motion under way, in a thread, and send none for a while."""
        with self._lock:
            self._alarmed = time.monotonic(), words
            if self.running() is None or self.alarm:
                return
            self.alarm = words
        self._warn("alarm", f"{words}: the motion was stopped")
        threading.Thread(target=self._stop_at_alarm, name="alarm", daemon=True).start()

    def _stop_at_alarm(self) -> None:
        try:
            self.stop()
        except UserError as error:
            self.alarm += f"; {error}"
            self._warn("alarm", self.alarm)

    def stop(self) -> dict[str, Any]:
        """Bring the motion under way to rest: on its path, or where the arm is if it left that.

        A controller may refuse a stop that begins too far from where it has got to meanwhile: it is
        sent again until the arm obeys.

        Raises:
            UserError: there is none, or the arm does not obey.
        """
        with self._stopping:
            return self._stop()

    def _stop(self) -> dict[str, Any]:
        sent = self._sent
        if sent is None:
            raise UserError("no motion is under way")
        publisher = self._publisher(sent.prepared.topic)
        for number, lead in enumerate(LEADS):
            start = 0 if sent.at_once else self._start(AHEAD)
            begins = self._elapsed(sent) + (AHEAD if start else lead)
            rest = self._rest(sent, begins, alike=number % 2 == 0)
            publisher.publish(message_of(rest, start))
            time.sleep(AHEAD + rest.duration)
            if self._obeys(sent, rest, begins):
                with self._lock:
                    self._sent = None if self._sent is sent else self._sent
                return {"seconds": rest.duration}
        raise UserError("the arm does not obey the stop: use the emergency stop")

    def _rest(self, sent: Sent, begins: float, alike: bool) -> Trajectory:
        """Return how the motion comes to rest.

        Args:
            begins: s since the motion began.
            alike: whether an arm near the motion stays on its path, and another one where it is;
                the other way round when that was refused.
        """
        trajectory = sent.prepared.plan.trajectory
        q, away = self._away(sent)
        if q is None or (away.max() < NEAR) == alike:
            return slowed(trajectory, begins)
        return held(trajectory.joints, q)

    def _obeys(self, sent: Sent, rest: Trajectory, began: float) -> bool:
        """Return whether the arm stands, and nearer to its way to rest than to the motion.

        Args:
            began: s since the motion began at which the stop did.
        """
        motion = sent.prepared.plan.trajectory
        for _ in range(LOOKS):
            before, _ = self._away(sent)
            first = self._elapsed(sent)
            time.sleep(LOOKED)
            q, away = self._away(sent)
            since = self._elapsed(sent)
            if q is None or before is None:
                break  # it cannot be seen
            going = motion.sample(np.array([first, since]))[0]
            there = rest.sample(since - began)[0]
            if np.abs(there - going[1]).max() < APART:
                continue  # the motion itself passes there
            would = np.abs(going[1] - going[0]).max()
            stands = np.abs(q - before).max() < max(STANDING, STILL * would)
            return bool(stands and np.abs(q - there).max() < away.max())
        return True

    def _start(self, ahead: float) -> int:
        """Return the stamp of the instant in `ahead` s, ns; 0 if the robot's clock is not known.

        With a stamp it does not matter how long a message takes. That of the joint states is taken
        for the robot's if it is ours, or if a simulation publishes one.
        """
        at, now = self._poses.at, int(self._node.get_clock().now().nanoseconds)
        known = abs(now - at) < SAME * 1e9 or self._node.count_publishers("/clock") > 0
        return at + round(ahead * 1e9) if known else 0

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
            return {
                "topic": sent.prepared.topic,
                "elapsed": max(0.0, elapsed),
                "seconds": seconds,
                "at": sent.at,
                "followed": sent.seen.followed,
            }

    def look(self) -> None:
        """Warn if the arm does not follow; to be called twice a second."""
        with self._lock:
            sent = self._sent
            if sent is None:
                return
            q, away = self._away(sent)
            if q is not None and (lead := sent.seen.lead(self._leads(sent, q))):
                at, steady = sent.at - round(lead * 1e9), sent.steady - lead
                at_once = sent.at_once or lead > SOON / 2
                sent = self._sent = replace(
                    sent, at=at, steady=steady, at_once=at_once, seen=Seen()
                )
                if at_once:
                    self._at_once.add(sent.prepared.topic)
                _, away = self._away(sent)
            if not sent.seen.follows(away):
                joint = sent.prepared.plan.trajectory.joints[int(away.argmax())]
                self._warn(
                    "not followed",
                    f"the arm does not follow the motion: {joint} is {away.max():.2g} rad off; "
                    f"the log of {', '.join(sent.prepared.nodes)} may say why",
                )

    def _leads(self, sent: Sent, q: Floats) -> Floats:
        """Return the distances (K, N) of a pose from where the motion would be, were it `EARLY`."""
        return np.abs(q - sent.prepared.plan.trajectory.sample(self._elapsed(sent) + EARLY)[0])

    def _away(self, sent: Sent) -> tuple[Floats | None, Floats]:
        """Return the pose (N,) rad and its distance from the motion; no pose if it is not known."""
        trajectory = sent.prepared.plan.trajectory
        try:
            q = self._poses.now(trajectory.joints)
        except UserError:
            return None, np.zeros(len(trajectory.joints))
        return q, np.abs(q - trajectory.sample(self._elapsed(sent))[0])

    def _elapsed(self, sent: Sent) -> float:
        """Return the s since a motion began: of the robot's clock while that is heard."""
        if self._poses.joints:
            return (self._poses.at - sent.at) / 1e9
        return time.monotonic() - sent.steady

    def _listeners(self, topic: str) -> tuple[str, ...]:
        """Return the full names of the nodes that subscribe, sorted; none until all are known."""
        try:
            found = self._node.get_subscriptions_info_by_topic(topic)
        except ValueError as error:
            raise UserError(f"{topic!r} is no topic: {error}") from error
        mine = [one for one in found if one.topic_type == TAKES]
        if any(one.node_name == UNKNOWN for one in mine):
            return ()  # they are still being discovered
        return tuple(sorted(f"{one.node_namespace.rstrip('/')}/{one.node_name}" for one in mine))

    def _connected(self, prepared: Prepared) -> Publisher:
        """Return the publisher once all who listen are connected to it."""
        publisher = self._publisher(prepared.topic)
        end = time.monotonic() + PATIENCE
        while publisher.get_subscription_count() < len(prepared.nodes):
            if time.monotonic() > end:
                raise UserError(f"{prepared.topic} is not connected: look again")
            time.sleep(0.02)
        return publisher

    def _publisher(self, topic: str) -> Publisher:
        if topic not in self._publishers:
            made = self._node.create_publisher(JointTrajectory, topic, RELIABLE)
            self._publishers[topic] = made
        return self._publishers[topic]
