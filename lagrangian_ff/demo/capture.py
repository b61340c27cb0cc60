"""What an arm said of itself along a trajectory: measured states and the reference beside them."""

from array import array
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from rclpy.node import Node
from rclpy.qos import HistoryPolicy, QoSProfile, ReliabilityPolicy
from sensor_msgs.msg import JointState

from lagrangian_ff.demo.errors import DemoError
from lagrangian_ff.nodes.common.joint_state_bytes import JointStateReader
from lagrangian_ff.nodes.common.polled import PolledSubscription
from lagrangian_ff.recording import Recording
from lagrangian_ff.report import Tracking

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

EVERYTHING = QoSProfile(
    history=HistoryPolicy.KEEP_LAST, depth=5000, reliability=ReliabilityPolicy.RELIABLE
)
LEAST = 0.7  # share of the samples without which a run is not judged


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

    An executor takes half a millisecond for each message, too much for 2000 a second beside the
    arms themselves: so messages are fetched many at once, serialised.

    Args:
        node: in whose name to listen.
        topic: of type JointState.
    """

    def __init__(self, node: Node, topic: str) -> None:
        self._subscription = PolledSubscription(node, JointState, topic, EVERYTHING, raw=True)
        self._messages: list[bytes] = []
        self._reader = JointStateReader()

    def latest(self) -> int:
        """Fetch what came; the stamp of the last message in ns, 0 before the first."""
        self._messages.extend(data for data, _ in self._subscription.take())
        return self._reader.read(self._messages[-1]).stamp if self._messages else 0

    def clear(self) -> None:
        """Forget all that came so far."""
        self.latest()
        self._messages.clear()

    def track(self) -> Track:
        """All messages as arrays, in the order of their stamps, each stamp once.

        Raises:
            DemoError: there are none.
        """
        if not self._messages:
            raise DemoError("no joint states came from the arm")
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
    label: str, measured: Track, reference: Track, start: int, duration: float, rate: float
) -> Tracking:
    """The error of a run, from the start of its trajectory to the end.

    Args:
        label: of the run.
        measured: joint states.
        reference: where the arm should have been, with the same stamps.
        start: ns, when the trajectory began.
        duration: s of the trajectory.
        rate: Hz of the joint states.

    Raises:
        DemoError: too many samples are missing.
    """
    end = start + round(duration * 1e9)
    stamps, one, other = np.intersect1d(
        measured.stamp, reference.stamp, assume_unique=True, return_indices=True
    )
    inside = (stamps >= start) & (stamps <= end)
    expected = duration * rate
    if inside.sum() < LEAST * expected:
        raise DemoError(
            f"run '{label}': {inside.sum()} of {expected:.0f} joint states came with their "
            "reference; the machine is too busy for this demo, close other programs"
        )
    if measured.joints != reference.joints:
        raise DemoError(f"run '{label}': the arm moves {measured.joints}, not {reference.joints}")
    error = reference.position[other[inside]] - measured.position[one[inside]]
    return Tracking(label, measured.joints, (stamps[inside] - start) / 1e9, error)


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
