"""The arm seen from the conductor: it is sent references, and what it reports is kept."""

import time

from rclpy.qos import HistoryPolicy, QoSProfile, ReliabilityPolicy
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

from lagrangian_ff.arm import Trajectory
from lagrangian_ff.demo.capture import Tape, Track, tracking
from lagrangian_ff.demo.conductor import Conductor
from lagrangian_ff.demo.errors import LostRunError
from lagrangian_ff.nodes.common.messages import nanoseconds, stamp
from lagrangian_ff.report import Tracking

RELIABLE = QoSProfile(
    history=HistoryPolicy.KEEP_LAST, depth=10, reliability=ReliabilityPolicy.RELIABLE
)
BEFORE = 0.5  # s of the arm in which it comes to rest before anything is asked of it
LEAD = 2.0  # s of the arm between sending a reference and its start, in which it is read
AFTER = 0.5  # s that are kept after the end of a trajectory
RATE = 500.0  # Hz of joint states


class ArmLink:
    """The topics and parameters of the arm node.

    Args:
        conductor: talks for us.
    """

    name = "/arm"
    _status = "arm: plant"

    def __init__(self, conductor: Conductor) -> None:
        self._conductor = conductor
        node, topic = conductor.node, f"{self.name}/joint_trajectory"
        self._measured = Tape(node, "/joint_states")
        self._until = round(BEFORE * 1e9)
        self._starts: list[int] = []
        self._direct = node.create_publisher(JointTrajectory, topic, RELIABLE)
        node.create_subscription(JointTrajectory, topic, self._on_trajectory, RELIABLE)

    def ready(self) -> bool:
        """Whether we can hear each other."""
        return (
            self._conductor.node.count_publishers("/joint_states") > 0
            and self._direct.get_subscription_count() >= 2
        )

    def feed(self, source: str) -> None:
        """Where its feedforward comes from: none, stream, trajectory or true."""
        self._conductor.set_parameters(self.name, {"feedforward_source": source})

    def run_clock(self, until: float = 0.0) -> None:
        """Let its clock go on until this time in s; 0 for ever."""
        self._conductor.set_parameters(self.name, {"clock_until": until})

    def send(self, trajectory: Trajectory) -> "Drive":
        """Send a trajectory straight to the arm, whose clock stands still soon after its end.

        So what happens meanwhile takes no time of the arm's, and recordings are always the same.
        """
        drive = self.listen(trajectory)
        start = self._until + round(LEAD * 1e9)
        self._until = start + round((trajectory.duration + AFTER) * 1e9)
        self._direct.publish(message_of(trajectory, start))
        self.run_clock(self._until / 1e9)
        return drive

    def listen(self, trajectory: Trajectory) -> "Drive":
        """The run of a trajectory that somebody is about to send to the arm."""
        self._measured.clear()
        self._starts.clear()
        return Drive(self, trajectory)

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
        """The arm's time: ns of the last joint state that came, 0 before the first."""
        return self._measured.latest()

    def track(self) -> Track:
        """What was measured since `listen`."""
        return self._measured.track()


class Drive:
    """One run of the arm along a trajectory, from being sent until it is over.

    Attributes:
        speed: times real time that the arm's clock went, from the start of the motion.
    """

    def __init__(self, link: ArmLink, trajectory: Trajectory) -> None:
        self._link = link
        self._trajectory = trajectory
        self._refused = link.refused()
        self._began: tuple[int, float] | None = None
        self.speed = 0.0

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
            LostRunError: the arm refused the trajectory.
        """
        if self._link.refused() > self._refused:
            raise LostRunError(f"{self._link.name} refused the motion: {self._link.refusal()}")
        start, now, real = self._link.start, self._link.reported(), time.monotonic()
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
        """The tracking error, and what was measured.

        Raises:
            LostRunError: too many samples are missing.
        """
        measured, start = self._link.track(), self._link.start
        found = tracking(label, measured, self._trajectory, start, RATE)
        # The filter of the conditioning settles while the arm still stands.
        return found, measured.between(start - round(AFTER * 1e9), self._end)


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
