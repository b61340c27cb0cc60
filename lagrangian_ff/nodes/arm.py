"""The simulated arm as a node, in place of a driver and a joint_trajectory_controller.

Topics
    ~/joint_trajectory  in   trajectory_msgs/JointTrajectory, the reference; header.stamp is
                             its start, 0 = now. One point at time 0 is a streamed set-point.
    ~/commands          in   std_msgs/Float64MultiArray, feedforward torque in joint order, N·m
    joint_states        out  sensor_msgs/JointState, 500 Hz, stamps on an exact grid
    ~/reference_state   out  sensor_msgs/JointState, the reference and the feedforward used, with
                             the stamps of joint_states
    robot_description   out  std_msgs/String, the URDF, latched
    /clock              out  rosgraph_msgs/Clock, 100 Hz, with `publish_clock`
    /diagnostics        out
"""

import sys
import time
import traceback

import numpy as np
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64MultiArray, String
from trajectory_msgs.msg import JointTrajectory

from lagrangian_ff import budget
from lagrangian_ff.arm import HOME, JOINTS, Arm, Trajectory, robot_description
from lagrangian_ff.arm.hiding import hidden, wanted
from lagrangian_ff.arm.simulation import check_limits
from lagrangian_ff.arrays import Floats
from lagrangian_ff.errors import UserError
from lagrangian_ff.nodes.common import topics
from lagrangian_ff.nodes.common.joint_state_bytes import JointStateMaker
from lagrangian_ff.nodes.common.node import ClosingNode, Diagnostics, Parameters, run
from lagrangian_ff.nodes.common.pacing import PacedThread, Pacer, RateMeter
from lagrangian_ff.nodes.common.status import Level, Status, ThrottledWarnings
from lagrangian_ff.nodes.streaming.reference import Follower, Segment, read_effort, read_reference

SOURCES = ("none", "stream", "trajectory", "true")
CHECK_STEP = 0.01  # s between the samples of a reference that are checked against the limits
FAR_BEHIND = 0.1  # s
CATCH_UP = 10  # ticks at once, then commands are looked at again
CLOCK_EVERY = 5  # ticks
STANDING = 0.01  # s between checks whether the clock may go on


class ArmNode(ClosingNode):
    """Steps the arm in a thread paced by the clock; callbacks only store what came.

    On a machine that is too slow no tick is left out, and stamps stay exact: the arm falls behind
    the clock and reports it, and torque streamed on ~/commands comes early. With `publish_clock`
    the arm has its own time, which slows down, together with everything that uses /clock.
    """

    def __init__(self) -> None:
        super().__init__("arm")
        self._settings = Parameters(self)
        declare(self._settings)
        value = self._settings.value
        self._own_clock: bool = value("publish_clock")
        asked = wanted(self._settings.strings("hidden"))
        inside = hidden(asked, value("seed"))
        self._arm = Arm(seed=value("seed"), loads=self._loads(), **inside.arm)
        q = np.array(value("initial_position"))
        self._arm.reset(q)
        self._follower = Follower(JOINTS, q, value("start_tolerance"))
        self._warnings = ThrottledWarnings(self.get_logger().warning)
        self._command = np.zeros(len(JOINTS))
        self._command_at = -np.inf
        self._in_step = False
        self._refusal = ""

        self._states = topics.advertise(self, JointState, "joint_states", topics.STATES)
        self._references = topics.advertise(self, JointState, "~/reference_state", topics.STATES)
        self._description = self.create_publisher(String, "robot_description", topics.LATCHED)
        self._description.publish(String(data=robot_description(self._loads())))
        self._state_maker = JointStateMaker(JOINTS)
        self._reference_maker = JointStateMaker(JOINTS)
        self.create_subscription(
            JointTrajectory,
            "~/joint_trajectory",
            self._on_trajectory,
            topics.RELIABLE,
            qos_overriding_options=topics.overridable(),
        )
        self._commands = topics.PolledSubscription(
            self, Float64MultiArray, "~/commands", topics.NEWEST
        )

        self._meter = RateMeter()
        self._squared_error, self._ticks, self._saturated = np.zeros(len(JOINTS)), 0, 0
        self._diagnostics = Diagnostics(
            self, "simulated arm", housekeeping=self._warnings.flush, plant=self._plant_status
        )
        self._clock_topic = (
            self.create_publisher(Clock, "/clock", topics.CLOCK) if self._own_clock else None
        )
        tick = self._arm.parameters.tick
        # Lost time is made up for; with its own clock none is lost.
        self._pacer = Pacer(tick, most=CATCH_UP, skip=self._own_clock)
        self._period, self._until = self._pacer.period, np.inf
        self._time = 0 if self._own_clock else time.time_ns()
        self._settings.watch(self._parameters_changed)
        self._loop = PacedThread(self._pacer, self._step, self._step_failed, "plant")
        self.get_logger().info(
            f"the arm stands at its initial position, {1.0 / tick:g} Hz, feedforward from: "
            f"{self._source}"
        )

    def _loads(self) -> dict[str, float]:
        loads = {joint: self._settings.value(f"loads.{joint}") for joint in JOINTS}
        return {joint: mass for joint, mass in loads.items() if mass > 0.0}

    def _parameters_changed(self) -> None:
        self._source: str = self._settings.value("feedforward_source")
        self._timeout: float = self._settings.value("command_timeout")
        waits = self._own_clock and self._source == "stream"
        self._patience: float = self._settings.value("wait_for_command") if waits else 0.0
        if self._own_clock:
            self._until = self._settings.value("clock_until") * 1e9 or np.inf
            self._pacer.speed = self._settings.value("clock_speed")

    def _on_command(self, message: Float64MultiArray) -> None:
        command = np.array(message.data)
        sound = np.abs(command) <= budget.LARGEST  # nan is not, either
        if command.shape != (len(JOINTS),) or not sound.all():
            self._warnings.add(
                "bad command",
                f"ignored a command on ~/commands with {len(command)} values, "
                f"{int(sound.sum())} of them torques; expected {len(JOINTS)}",
            )
            return
        self._command, self._command_at, self._in_step = command, self._time, True

    def _on_trajectory(self, message: JointTrajectory) -> None:
        now = self._time
        try:
            given = topics.points(message)
            reference = read_reference(given, JOINTS)
            effort = read_effort(given, JOINTS)
            last = max(reference.duration, CHECK_STEP)  # a set-point stays for a moment
            fine = np.linspace(0.0, last, int(last / CHECK_STEP) + 2)
            check_limits(Trajectory(fine, *reference.sample(fine)))
            segment = Segment(reference, topics.nanoseconds(message.header.stamp) or now, effort)
            self._follower.accept(segment, now)
        except UserError as error:
            self._refusal = str(error)
            self._warnings.add("refused trajectory", f"refused a trajectory: {error}")
            return
        if not reference.is_setpoint:
            self.get_logger().info(
                f"following a trajectory of {len(reference.time)} points, "
                f"{reference.duration:.3f} s, in {(segment.start - now) / 1e9:.3f} s; "
                f"filled in: {', '.join(reference.filled) or 'nothing'}"
            )

    def _take_commands(self) -> int:
        """Take the waiting commands and return their number."""
        messages = [message for message, _ in self._commands.take()]
        for message in messages:
            self._on_command(message)
        return len(messages)

    def _await_command(self) -> None:
        """Take the commands since the last tick; wait for one if the stream answers every state."""
        if self._take_commands() or not self._in_step or self._patience == 0.0:
            return
        self._commands.wait(self._patience)
        if not self._take_commands():
            self._in_step = False
            self._warnings.add(
                "missing command", f"no command came within {self._patience:g} s: not waiting now"
            )

    def _step(self, due: range) -> None:
        for _ in due:
            if self._time >= self._until:
                time.sleep(STANDING)
                return
            self._await_command()
            self._time += self._period
            now = self._time
            q, qd, qdd, effort = self._follower.at(now)
            torque = self._feedforward(q, qd, qdd, effort)
            sample = self._arm.step(q, qd, torque)
            self._states.publish(
                self._state_maker.fill(now, sample.position, sample.velocity, sample.effort)
            )
            if self._references.get_subscription_count():
                self._references.publish(self._reference_maker.fill(now, q, qd, torque))
            self._squared_error += (q - sample.position) ** 2
            self._ticks += 1
            self._saturated += bool(self._arm.saturated.any())
            if self._clock_topic is not None and now // self._period % CLOCK_EVERY == 0:
                self._clock_topic.publish(Clock(clock=topics.stamp(now)))
        self._meter.add(len(due))

    def _feedforward(self, q: Floats, qd: Floats, qdd: Floats, effort: Floats) -> Floats:
        """Return the torque to add now, (6,) N·m."""
        if self._source == "stream":
            age = (self._time - self._command_at) / 1e9
            if self._timeout == 0.0 or age <= self._timeout:
                return self._command
        elif self._source == "trajectory":
            return effort
        elif self._source == "true":
            return self._arm.plant.true_torque(q, qd, qdd)
        return np.zeros(len(JOINTS))

    def _step_failed(self, error: Exception) -> None:
        text = str(error) if isinstance(error, UserError) else traceback.format_exc()
        self._warnings.add("failed tick", f"a tick failed: {text}")

    def _plant_status(self) -> Status:
        rate = self._meter.take()
        ticks, self._ticks = max(self._ticks, 1), 0
        error, self._squared_error = np.sqrt(self._squared_error / ticks), np.zeros(len(JOINTS))
        saturated, self._saturated = self._saturated, 0
        factor = rate * self._arm.parameters.tick
        level, message = Level.OK, "moving" if self._follower.moving(self._time) else "standing"
        if self._pacer.speed == 0.0 or self._time >= self._until:
            message = "its clock stands still"
        elif self._pacer.behind > FAR_BEHIND and not self._own_clock:
            level, message = Level.WARN, f"{self._pacer.behind:.2f} s behind the clock"
        elif saturated:
            level, message = Level.WARN, f"torque limit reached in {saturated} ticks"
        elif self._source == "trajectory" and not self._follower.has_effort:
            level, message = Level.WARN, "the reference carries no effort to add"
        values = {
            "real-time factor": factor,
            "late ticks": self._pacer.late,
            "behind the clock [s]": self._pacer.behind,
            "ticks at the torque limit": saturated,
            "feedforward source": self._source,
            "command age [s]": (self._time - self._command_at) / 1e9,
            **{
                f"RMS tracking error {joint} [rad]": float(value)
                for joint, value in zip(JOINTS, error, strict=True)
            },
            **self._warnings.counts,
            "last refusal": self._refusal,
        }
        return Status(level, message, values)

    def close(self) -> None:
        """Stop the plant."""
        self._loop.stop()
        self._arm.close()


def declare(parameters: Parameters) -> None:
    """Declare all parameters."""
    add = parameters.declare
    add("feedforward_source", "stream", "where the feedforward torque comes from: none; stream: "
        "~/commands; trajectory: points[i].effort of the reference; true: the plant's own torques "
        "for it, the bound of what feedforward can reach", choices=SOURCES)  # fmt: skip
    add("command_timeout", 0.1, "s after which a command on ~/commands no longer acts; 0 = never",
        low=0.0, high=10.0)  # fmt: skip
    add("publish_clock", False, "whether the arm has its own time, from 0 on, published on /clock: "
        "it slows down if the machine cannot keep up", read_only=True)  # fmt: skip
    add("clock_speed", 1.0, "fastest speed of the arm's clock, as a factor of real time; 0 = it "
        "stands still", low=0.0, high=100.0)  # fmt: skip
    add("clock_until", 0.0, "time on the arm's clock at which the clock stops, s; 0 = never",
        low=0.0, high=1e9)  # fmt: skip
    add("wait_for_command", 0.0, "s of real time that the arm's clock waits at a tick for a new "
        "command on ~/commands, for a stream that answers every joint state; 0 = never",
        low=0.0, high=10.0)  # fmt: skip
    add("start_tolerance", 0.05, "rad by which a new reference may differ from the present one "
        "when it takes over", low=0.0, high=3.2, read_only=True)  # fmt: skip
    add("seed", 0, "of the sensor noise", low=0, high=2**31, read_only=True)
    add("initial_position", list(HOME), "rad, the 6 joints at the start", read_only=True)
    add("hidden", [""], 'physics to hide, EFFECT@JOINT:SIZE, as stribeck@joint_3:0.1 of a tenth of '
        'the torque of joint_3; `lagrangian_ff simulate --help` lists the effects; [""] = none',
        read_only=True)  # fmt: skip
    for joint in JOINTS:
        add(f"loads.{joint}", 0.0, f"kg fixed to the link that {joint} moves; 0 = none",
            low=0.0, high=20.0, read_only=True)  # fmt: skip


def main() -> int:
    """Run the executable `arm`."""
    return run(ArmNode, sys.argv)


if __name__ == "__main__":
    sys.exit(main())
