"""What an arm said of itself along a trajectory."""

from array import array
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from rclpy.node import Node
from rclpy.qos import HistoryPolicy, QoSProfile, ReliabilityPolicy
from sensor_msgs.msg import JointState

from lagrangian_ff.arm import Trajectory
from lagrangian_ff.demo.errors import LostRunError
from lagrangian_ff.nodes.common.joint_state_bytes import JointStateReader
from lagrangian_ff.nodes.common.polled import PolledSubscription
from lagrangian_ff.recording import Recording
from lagrangian_ff.report import Tracking

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

EVERYTHING = QoSProfile(
    history=HistoryPolicy.KEEP_LAST, depth=5000, reliability=ReliabilityPolicy.RELIABLE
)
LEAST = 0.99  # share of the samples without which a run is not judged


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
        """The samples stamped in this time."""
        return self.take((self.stamp >= first) & (self.stamp <= last))

    def take(self, index: "NDArray[np.bool_] | Ints") -> "Track":
        """Some of the samples."""
        return Track(
            self.joints,
            self.stamp[index],
            self.position[index],
            self.velocity[index],
            self.effort[index],
        )


class Tape:
    """Keeps the joint states of a topic as they come.

    An executor takes half a millisecond for each message, too much for 1000 a second beside the
    arm itself: so messages are fetched many at once, serialised.

    Args:
        node: in whose name to listen.
        topic: of type JointState.
    """

    def __init__(self, node: Node, topic: str) -> None:
        self._subscription = PolledSubscription(node, JointState, topic, EVERYTHING, raw=True)
        self._messages: list[bytes] = []
        self._reader = JointStateReader()
        self._latest = 0

    def latest(self) -> int:
        """Fetch what came; the stamp of the last message in ns, 0 before the first."""
        came = [data for data, _ in self._subscription.take()]
        if came:
            self._messages += came
            self._latest = self._reader.read(came[-1]).stamp
        return self._latest

    def clear(self) -> None:
        """Forget all that came so far, but the stamp of the last."""
        self.latest()
        self._messages.clear()

    def track(self) -> Track:
        """All messages as arrays, in the order of their stamps, each stamp once.

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
    """The error of a run, from the start of its trajectory to the end.

    Args:
        label: of the run.
        measured: joint states.
        trajectory: where the arm should have been.
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
    """Joint states as a recording."""
    start = float(track.stamp[0]) / 1e9
    return Recording(
        joints=track.joints,
        time=(track.stamp - track.stamp[0]) / 1e9,
        position=track.position,
        velocity=track.velocity,
        effort=track.effort,
        start=start,
        source=source,
    )
