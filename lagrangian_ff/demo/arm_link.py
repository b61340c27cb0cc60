"""One arm seen from the conductor: it is sent references, and what it reports is kept."""

from dataclasses import dataclass

from rclpy.qos import HistoryPolicy, QoSProfile, ReliabilityPolicy
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

from lagrangian_ff.arm import Trajectory
from lagrangian_ff.demo.capture import Tape, Track, tracking
from lagrangian_ff.demo.conductor import Conductor
from lagrangian_ff.demo.errors import DemoError
from lagrangian_ff.nodes.common.messages import nanoseconds, stamp
from lagrangian_ff.report import Tracking

RELIABLE = QoSProfile(
    history=HistoryPolicy.KEEP_LAST, depth=10, reliability=ReliabilityPolicy.RELIABLE
)
LEAD = 2.0  # s between sending a reference and its start: a busy arm reads it in that time
AFTER = 0.3  # s that are kept after the end of a trajectory
RATE = 500.0  # Hz of joint states


@dataclass(frozen=True)
class Pace:
    """How well an arm kept up with the clock during a run.

    Attributes:
        late: ticks that came at least one period late.
        behind: s it was behind at most.
    """

    late: int
    behind: float


class ArmLink:
    """The topics of one arm node.

    Args:
        conductor: talks for us.
        namespace: of the arm; empty for none.
        reference_topic: where references for this arm are sent.
    """

    def __init__(self, conductor: Conductor, namespace: str = "") -> None:
        self._conductor = conductor
        self._prefix = f"/{namespace}" if namespace else ""
        self._status = f"{self._prefix}/arm: plant".lstrip("/")
        node = conductor.node
        self._measured, self._reference = (
            Tape(conductor.node, f"{self._prefix}/{topic}")
            for topic in ("joint_states", "arm/reference_state")
        )
        self._topic = f"{self._prefix}/arm/joint_trajectory"
        self._starts: list[int] = []
        self._direct = node.create_publisher(JointTrajectory, self._topic, RELIABLE)
        node.create_subscription(JointTrajectory, self._topic, self._on_trajectory, RELIABLE)

    @property
    def name(self) -> str:
        """Fully qualified name of the node."""
        return f"{self._prefix}/arm"

    def ready(self) -> bool:
        """Whether it reports its joints and hears our references."""
        return self._measured.latest() > 0 and self._direct.get_subscription_count() >= 2

    def feed(self, source: str) -> None:
        """Where its feedforward comes from: none, stream, trajectory or true."""
        self._conductor.set_parameters(self.name, {"feedforward_source": source})

    def send(self, trajectory: Trajectory) -> "Drive":
        """Send a trajectory straight to the arm."""
        message = message_of(trajectory, 0)
        drive = self.listen(trajectory)
        message.header.stamp = stamp(self._conductor.now() + round(LEAD * 1e9))
        self._direct.publish(message)
        return drive

    def listen(self, trajectory: Trajectory) -> "Drive":
        """The run of a trajectory that somebody is about to send to the arm."""
        for tape in (self._measured, self._reference):
            tape.clear()
        self._starts.clear()
        return Drive(self, trajectory, len(self._conductor.history.get(self._status, [])))

    def _on_trajectory(self, message: JointTrajectory) -> None:
        self._starts.append(nanoseconds(message.header.stamp))

    @property
    def start(self) -> int:
        """Ns of the start of the last trajectory that was sent to it; 0 before there was one."""
        return self._starts[-1] if self._starts else 0

    def refused(self) -> int:
        """How many references it refused since it started."""
        return int(self._conductor.status(self._status).get("refused trajectory", "0"))

    def refusal(self) -> str:
        """Why it refused the last one."""
        return self._conductor.status(self._status).get("last refusal", "")

    def reported(self) -> int:
        """Ns of the last joint state and reference that came."""
        return min(self._measured.latest(), self._reference.latest())

    def tracks(self) -> tuple[Track, Track]:
        """What was measured and what it should have been."""
        return self._measured.track(), self._reference.track()

    def pace(self, since: int) -> Pace:
        """How it kept up with the clock since this entry of its diagnostics."""
        history = self._conductor.history.get(self._status, [])[max(0, since - 1) :]
        if not history:
            return Pace(0, 0.0)
        late = int(history[-1]["late ticks"]) - int(history[0]["late ticks"])
        return Pace(late, max(float(values["behind the clock [s]"]) for values in history))


class Drive:
    """One run of an arm along a trajectory, from being sent until it is over."""

    def __init__(self, link: ArmLink, trajectory: Trajectory, since: int) -> None:
        self._link = link
        self._trajectory = trajectory
        self._since = since
        self._refused = link.refused()

    @property
    def fraction(self) -> float:
        """Done so far, 0 to 1."""
        if not self._link.start:
            return 0.0
        elapsed = (self._link.reported() - self._link.start) / 1e9
        return min(1.0, max(0.0, elapsed / self._trajectory.duration))

    def over(self) -> bool:
        """Whether the arm has come to the end and a little further.

        Raises:
            DemoError: the arm refused the trajectory.
        """
        if self._link.refused() > self._refused:
            raise DemoError(
                f"{self._link.name} refused the motion: {self._link.refusal()}. Where the "
                "machine was busy, run the demo again with nothing beside it"
            )
        end = self._link.start + round((self._trajectory.duration + AFTER) * 1e9)
        return bool(self._link.start) and self._link.reported() >= end

    def result(self, label: str) -> tuple[Tracking, Track, Pace]:
        """The tracking error, what was measured meanwhile, and how the arm kept up."""
        measured, reference = self._link.tracks()
        duration = self._trajectory.duration
        found = tracking(label, measured, reference, self._link.start, duration, RATE)
        end = self._link.start + round((duration + AFTER) * 1e9)
        # The filter of the conditioning settles while the arm still stands.
        inside = measured.between(self._link.start - round(AFTER * 1e9), end)
        return found, inside, self._link.pace(self._since)


def message_of(trajectory: Trajectory, start: int) -> JointTrajectory:
    """A trajectory as a message.

    Args:
        trajectory: its effort is not sent.
        start: ns; 0 leaves it to the receiver.
    """
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
