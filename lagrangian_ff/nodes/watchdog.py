"""The watchdog node: passes a stream of torques on, and fades it to zero when it stops.

Topics
    feedforward/commands  in   std_msgs/Float64MultiArray, N·m in the order of `joints`
    robot_description     in   std_msgs/String, for the torque limits of `joints`
    ~/commands            out  the same within its limits: give this to the controller
    /diagnostics          out

A process that is killed sends no last zero, and most controllers hold the last torque for ever.
This one lives apart from the feedforward and does nothing else, so that there is little to break
it. It can be killed like any other: it is not a safety function.
"""

import sys
import time

import numpy as np
from rclpy.duration import Duration
from std_msgs.msg import Float64MultiArray, String

from lagrangian_ff.nodes.common import topics
from lagrangian_ff.nodes.common.joint_state_bytes import MessageError
from lagrangian_ff.nodes.common.node import ClosingNode, Diagnostics, Parameters, run
from lagrangian_ff.nodes.common.pacing import NodeTime, PacedThread, RateMeter
from lagrangian_ff.nodes.common.status import Level, Status, ThrottledWarnings
from lagrangian_ff.nodes.streaming.guard import NO_LIMIT, Guard, GuardSettings
from lagrangian_ff.nodes.streaming.plan import reason
from lagrangian_ff.nodes.streaming.stream import (
    FAREWELL,
    LATE,
    LIMITS_PER_SECOND,
    LONGEST_STEP,
    effort_limits,
)


class _Arrivals:
    """The instants to work at: whenever a torque comes, and every period without one."""

    def __init__(self, subscription: topics.PolledSubscription, period: float) -> None:
        self._subscription, self._period = subscription, period

    def wait(self) -> range:
        self._subscription.wait(self._period)
        return range(1)


class WatchdogNode(ClosingNode):
    """The topics and parameters around a guard."""

    def __init__(self) -> None:
        super().__init__("watchdog")
        self._given = Parameters(self)
        declare(self._given)
        self._joints = self._given.strings("joints")
        declare_joints(self._given, self._joints)
        self._given.refuse_unknown("limits")
        self._warnings = ThrottledWarnings(self.get_logger().warning)
        self._described: dict[str, float] = {}
        self._time = NodeTime(self)
        self._rate = self._given.value("rate")
        self._guard = Guard(self._settings(), len(self._joints))
        self._given.watch(self._refresh)
        self._meter, self._fades, self._silent = RateMeter(), 0, True
        self._commands = topics.advertise(self, Float64MultiArray, "~/commands", topics.RELIABLE)
        self._input = topics.PolledSubscription(
            self, Float64MultiArray, "feedforward/commands", topics.SHARED
        )
        self.create_subscription(String, "robot_description", self._on_description, topics.LATCHED)
        self._loop = PacedThread(
            _Arrivals(self._input, 1.0 / self._rate), self._tick, self._failed, "watchdog"
        )
        self._diagnostics = Diagnostics(
            self, "watchdog", housekeeping=self._warnings.flush, torque=self._status
        )
        self.get_logger().info(f"passes {self._input.topic} on to {self._commands.topic_name}")

    def _settings(self) -> GuardSettings:
        value, joints = self._given.value, self._joints
        limit = np.array(
            [value(f"limits.{joint}.effort") or self._described.get(joint, 0.0) for joint in joints]
            or [0.0]
        )
        limit = np.where(limit > 0.0, limit, NO_LIMIT)
        rate = np.array([value(f"limits.{joint}.effort_rate") for joint in joints] or [0.0])
        return GuardSettings(
            effort_limit=limit,
            effort_rate=np.where(rate > 0.0, rate, LIMITS_PER_SECOND * limit),
            timeout=value("timeout"),
            fade_time=value("fade_time"),
            ramp_time=value("ramp_time"),
            longest=max(LATE / self._rate, LONGEST_STEP if self._time.simulated else 0.0),
        )

    def _refresh(self) -> None:
        self._guard.settings = self._settings()

    def _on_description(self, message: String) -> None:
        try:
            self._described = effort_limits(message.data)
        except MessageError as error:
            self._warnings.add("bad robot description", str(error))
            return
        self._refresh()

    def _tick(self, due: range) -> None:
        came = False
        steady = self._time.steady()
        for message, _ in self._input.take():
            fault = self._guard.take(np.array(message.data), steady)
            came = came or not fault
            if fault:
                self._warnings.add("not passed on", f"a message was not passed on: {fault}")
        self._meter.add(came)
        tau = self._guard.tick(steady)
        silent = self._guard.silent
        if silent and not self._silent:
            self._fades += 1
            self._warnings.add("faded", f"torque fades to zero: {self._silence()}")
        self._silent = silent
        if tau is not None:
            self._commands.publish(topics.command(tau))

    def _failed(self, error: Exception) -> None:
        self._warnings.add("failed tick", f"a tick failed: {reason(error)}")

    def _silence(self) -> str:
        timeout = self._guard.settings.timeout
        return f"no torque on {self._input.topic} for {timeout:g} s; is the feedforward alive?"

    def _status(self) -> Status:
        limits = zip(self._joints, self._guard.settings.effort_limit, strict=False)
        known = {joint: float(limit) for joint, limit in limits if limit < NO_LIMIT}
        rate = self._meter.take()
        senders = self.count_publishers(self._input.topic)
        values = {
            "torques passed on [Hz]": rate,
            "fades": self._fades,
            "receivers of commands": self._commands.get_subscription_count(),
            **{f"effort limit {joint} [N·m]": limit for joint, limit in known.items()},
            **self._warnings.values(),
        }
        if senders > 1:
            said = f"{senders} nodes send torque on {self._input.topic} in turn: end all but one"
            return Status(Level.WARN, said, values)
        if self._guard.sent is None:
            return Status(Level.STALE, f"no torque came yet on {self._input.topic}", values)
        if self._guard.silent:
            state = "torque is zero" if self._guard.resting else "torque fades to zero"
            return Status(Level.STALE, f"{state}: {self._silence()}", values)
        if not rate and self._time.simulated:
            return Status(Level.WARN, "simulated time stands, and silence cannot be told", values)
        return Status(Level.OK, f"passes torque on, {rate:.0f} Hz", values)

    def close(self) -> None:
        """Fade out, then send zeros."""
        self._guard.end()
        deadline = time.monotonic() + 2.0 * self._guard.settings.fade_time + 0.5
        while time.monotonic() < deadline and not self._guard.resting:
            time.sleep(0.005)
        self._loop.stop()
        if self._guard.sent is not None:
            for _ in range(FAREWELL):
                self._commands.publish(topics.command(0.0 * self._guard.sent))
            self._commands.wait_for_all_acked(Duration(seconds=0.2))


def declare(parameters: Parameters) -> None:
    """Declare the parameters that do not depend on the joints."""
    add = parameters.declare
    add("joints", [""], 'order of the torques, for their limits; [""] = any number, no limits',
        read_only=True)  # fmt: skip
    add("rate", 500.0, "Hz at which the torque is faded and zeros are sent", low=1.0, high=2000.0,
        read_only=True)  # fmt: skip
    add("timeout", 0.1, "s without a torque after which it fades", low=0.001, high=10.0)
    add("fade_time", 0.5, "s in which the torque is faded to zero", low=0.0, high=3.0)
    add("ramp_time", 0.1, "s in which the torque is brought in when it comes", low=0.0, high=10.0)


def declare_joints(parameters: Parameters, joints: tuple[str, ...]) -> None:
    """Declare the limits of each joint."""
    for joint in joints:
        parameters.declare(f"limits.{joint}.effort", 0.0, "N·m at most; 0 = of the robot "
            "description, or without one no limit", low=0.0, high=1e6)  # fmt: skip
        parameters.declare(f"limits.{joint}.effort_rate", 0.0, f"N·m/s at most; 0 = "
            f"{LIMITS_PER_SECOND:g} torque limits a second", low=0.0, high=1e8)  # fmt: skip


def main() -> int:
    """Run the executable `watchdog`."""
    return run(WatchdogNode, sys.argv)


if __name__ == "__main__":
    sys.exit(main())
