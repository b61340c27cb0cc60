"""The link to the arm: references go to it, and its joint states are kept."""

import time
from array import array
from dataclasses import dataclass, fields

import numpy as np
from rclpy.node import Node
from rclpy.qos import QoSProfile, ReliabilityPolicy
from sensor_msgs.msg import JointState
from trajectory_msgs.msg import JointTrajectory

from lagrangian_ff.arm import Trajectory
from lagrangian_ff.arrays import Floats, Ints
from lagrangian_ff.demo.conductor import Conductor
from lagrangian_ff.errors import LostRunError
from lagrangian_ff.nodes.common.joint_state_bytes import JointStateReader
from lagrangian_ff.nodes.common.topics import RELIABLE, PolledSubscription, message_of, nanoseconds
from lagrangian_ff.recording import Recording
from lagrangian_ff.report import Tracking

BEFORE = 0.5  # s of the arm in which it comes to rest
LEAD = 2.0  # s of the arm between sending a reference and its start, for reading it
AFTER = 0.5  # s that are kept after the end of a trajectory
RATE = 500.0  # Hz of joint states
EVERYTHING = QoSProfile(depth=5000, reliability=ReliabilityPolicy.RELIABLE)
NAME = "/arm"
LEAST = 0.99  # least share of the samples of a run that is judged


@dataclass(frozen=True)
class Track:
    """Joint states as they came.

    Attributes:
        joints: N names.
        stamp: (M,) ns, increasing.
        position, velocity, effort: (M, N).
    """

    joints: tuple[str, ...]
    stamp: Ints
    position: Floats
    velocity: Floats
    effort: Floats

    def between(self, first: int, last: int) -> "Track":
        """Return the samples stamped in this time."""
        inside = (self.stamp >= first) & (self.stamp <= last)
        return Track(self.joints, *(getattr(self, f.name)[inside] for f in fields(self)[1:]))


class Tape:
    """Keeps the joint states of a topic as they come.

    An executor takes half a millisecond for each message, too much for 1000 a second: messages are
    fetched many at once, serialised.
    """

    def __init__(self, node: Node, topic: str) -> None:
        self._subscription = PolledSubscription(node, JointState, topic, EVERYTHING, raw=True)
        self._messages: list[bytes] = []
        self._reader = JointStateReader()
        self._latest = 0

    def latest(self) -> int:
        """Fetch new messages; return the stamp of the last in ns, 0 before the first."""
        came = [data for data, _ in self._subscription.take()]
        if came:
            self._messages += came
            self._latest = self._reader.read(came[-1]).stamp
        return self._latest

    def clear(self) -> None:
        """Drop all messages so far, but keep the stamp of the last."""
        self.latest()
        self._messages.clear()

    def track(self) -> Track:
        """Return all messages as arrays, in the order of their stamps, each stamp once.

        Raises:
            LostRunError: there are none.
        """
        if not self._messages:
            raise LostRunError("no joint states came from the arm")
        stamps = array("q")
        values: dict[str, list[Floats]] = {"position": [], "velocity": [], "effort": []}
        joints: tuple[str, ...] = ()
        for data in self._messages:
            view = self._reader.read(data)
            joints = view.names
            stamps.append(view.stamp)
            for name, rows in values.items():
                rows.append(getattr(view, name))
        stamp, first = np.unique(np.array(stamps, dtype=np.int64), return_index=True)
        return Track(joints, stamp, *(np.array(rows)[first] for rows in values.values()))


def tracking(
    label: str, measured: Track, trajectory: Trajectory, start: int, rate: float
) -> Tracking:
    """Return the error of a run, from the start of its trajectory to the end.

    Args:
        start: ns, when the trajectory began.
        rate: Hz of the joint states.

    Raises:
        LostRunError: too many samples are missing.
    """
    inside = measured.between(start, start + round(trajectory.duration * 1e9))
    expected = trajectory.duration * rate
    if len(inside.stamp) < LEAST * expected:
        raise LostRunError(
            f"run '{label}': {len(inside.stamp)} of {expected:.0f} joint states came"
        )
    time = (inside.stamp - start) / 1e9
    wanted, _, _ = trajectory.select(measured.joints).sample(trajectory.time[0] + time)
    return Tracking(label, measured.joints, time, wanted - inside.position)


def recording_of(track: Track, source: str) -> Recording:
    """Return joint states as a recording."""
    time, start = (track.stamp - track.stamp[0]) / 1e9, float(track.stamp[0]) / 1e9
    tables = track.position, track.velocity, track.effort
    return Recording(track.joints, time, *tables, start, source)


class ArmLink:
    """The topics and parameters of the arm node.

    Attributes:
        measured: the joint states since `listen`.
        start: ns, of the trajectory that was sent since then; 0 before.
    """

    def __init__(self, conductor: Conductor) -> None:
        self._conductor = conductor
        node, topic = conductor.node, f"{NAME}/joint_trajectory"
        self.measured = Tape(node, "/joint_states")
        self._until = round(BEFORE * 1e9)
        self.start = 0
        self._direct = node.create_publisher(JointTrajectory, topic, RELIABLE)
        node.create_subscription(JointTrajectory, topic, self._on_trajectory, RELIABLE)

    def ready(self) -> bool:
        """Return whether both sides have met."""
        publishing = self._conductor.node.count_publishers("/joint_states") > 0
        return publishing and self._direct.get_subscription_count() >= 2

    def set(self, **parameters: object) -> None:
        """Set parameters of the node."""
        self._conductor.set_parameters(NAME, parameters)

    def send(self, trajectory: Trajectory) -> "Drive":
        """Send a trajectory straight to the arm, whose clock stops soon after its end.

        The arm then waits for slower nodes, and recordings are always the same.
        """
        drive = self.listen(trajectory)
        start = self._until + round(LEAD * 1e9)
        self._until = start + round((trajectory.duration + AFTER) * 1e9)
        self._direct.publish(message_of(trajectory, start))
        self.set(clock_until=self._until / 1e9)
        return drive

    def listen(self, trajectory: Trajectory) -> "Drive":
        """Return the run of a trajectory that is about to be sent to the arm."""
        self.measured.clear()
        self.start = 0
        return Drive(self, trajectory)

    def _on_trajectory(self, message: JointTrajectory) -> None:
        self.start = nanoseconds(message.header.stamp)

    def refusals(self) -> tuple[int, str]:
        """Return how many references it refused since it started, and why the last one."""
        status = self._conductor.status("arm: plant")
        return int(status.get("refused trajectory", "0")), status.get("last refusal", "")


class Drive:
    """One run of the arm along a trajectory, from being sent until it is over.

    Attributes:
        speed: times real time that the arm's clock went, from the start of the motion.
    """

    def __init__(self, link: ArmLink, trajectory: Trajectory) -> None:
        self._link = link
        self._trajectory = trajectory
        self._refused, _ = link.refusals()
        self._began: tuple[int, float] | None = None
        self.speed = 0.0

    @property
    def fraction(self) -> float:
        """Return the share done, 0 to 1."""
        if not self._link.start:
            return 0.0
        elapsed = (self._link.measured.latest() - self._link.start) / 1e9
        return min(1.0, max(0.0, elapsed / self._trajectory.duration))

    def over(self) -> bool:
        """Return whether the arm has reached the end and a little more.

        Raises:
            LostRunError: the arm refused the trajectory.
        """
        refused, why = self._link.refusals()
        if refused > self._refused:
            raise LostRunError(f"{NAME} refused the motion: {why}")
        start, now, real = self._link.start, self._link.measured.latest(), time.monotonic()
        if not start or now < start:
            return False
        if self._began is None:
            self._began = now, real
        self.speed = (now - self._began[0]) / 1e9 / max(real - self._began[1], 1e-9)
        return now >= self._end

    @property
    def _end(self) -> int:
        return self._link.start + round((self._trajectory.duration + AFTER) * 1e9)

    def result(self, label: str) -> tuple[Tracking, Track]:
        """Return the tracking error and the joint states.

        Raises:
            LostRunError: too many samples are missing.
        """
        measured, start = self._link.measured.track(), self._link.start
        found = tracking(label, measured, self._trajectory, start, RATE)
        # The filter of the conditioning settles while the arm still stands.
        return found, measured.between(start - round(AFTER * 1e9), self._end)
