"""A process in place of ros2_control: joint_trajectory_controller on the simulated arm.

It has the controller's action, its parameters and the two services of the controller manager. The
arm's position loop is the controller's PID. How well a goal was tracked is in its output: of the
feedback, messages are lost where a client is late.
"""

import contextlib
import sys
import time
from typing import Any

import numpy as np
import rclpy
from control_msgs.action import FollowJointTrajectory
from controller_manager_msgs.msg import ControllerState, HardwareInterface
from controller_manager_msgs.srv import ListControllers, ListHardwareInterfaces
from controller_rules import Motion, complaint
from rclpy.action import ActionServer, CancelResponse, GoalResponse
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from rclpy.task import Future
from rclpy.time import Time
from sensor_msgs.msg import JointState

from lagrangian_ff.arm import HOME, JOINTS, Arm
from lagrangian_ff.arm.hiding import hidden, wanted

NAME = "joint_trajectory_controller"
TICK = 0.002
Result = FollowJointTrajectory.Result


class Controller(Node):
    """Steps the arm and follows one goal at a time."""

    def __init__(self) -> None:
        super().__init__(NAME)
        inside = hidden(
            wanted([text for text in self.declare_parameter("hidden", [""]).value if text]), 0
        )
        self._arm = Arm(seed=0, **inside.arm)
        self._arm.reset(np.array(HOME))
        self._q = np.array(HOME)
        self._kinds = list(self.declare_parameter("command_interfaces", ["effort"]).value)
        offered = self.declare_parameter("offered", ["position", "effort"]).value
        self._offered = [f"{joint}/{kind}" for joint in JOINTS for kind in offered]
        self._type = self.declare_parameter("type", f"{NAME}/JointTrajectoryController").value
        # A controller that was built before effort was taken.
        self._old = bool(self.declare_parameter("old", False).value)
        self._tolerance = float(self.declare_parameter("path_tolerance", 0.0).value)
        # Simulated seconds a second.
        self._speed = float(self.declare_parameter("speed", 3.0).value)
        for joint in JOINTS:
            self.declare_parameter(f"gains.{joint}.ff_velocity_scale", 0.0)
        self._goal: Any = None
        self._done: Future | None = None
        self._motion: Motion | None = None
        self._began, self._ticks = 0.0, 0
        self._squares: list[float] = []  # rad², of the error of tracking, of each tick of a goal
        self._waiting: Any = None
        self.create_service(
            ListControllers, "controller_manager/list_controllers", self._controllers
        )
        self.create_service(
            ListHardwareInterfaces, "controller_manager/list_hardware_interfaces", self._hardware
        )
        self._states = self.create_publisher(JointState, "joint_states", 100)
        group = ReentrantCallbackGroup()
        ActionServer(
            self,
            FollowJointTrajectory,
            f"{NAME}/follow_joint_trajectory",
            self._execute,
            goal_callback=self._on_goal,
            cancel_callback=lambda goal: CancelResponse.ACCEPT,
            callback_group=group,
        )
        self._start = time.monotonic()
        self._epoch = self.get_clock().now().nanoseconds
        self._lost = 0.0  # s
        self.create_timer(0.01, self._catch_up, callback_group=group)

    def _controllers(
        self, request: ListControllers.Request, response: ListControllers.Response
    ) -> ListControllers.Response:
        claimed = [f"{joint}/{kind}" for joint in JOINTS for kind in self._kinds]
        response.controller = [
            ControllerState(name=NAME, state="active", type=self._type, claimed_interfaces=claimed)
        ]
        return response

    def _hardware(
        self, request: ListHardwareInterfaces.Request, response: ListHardwareInterfaces.Response
    ) -> ListHardwareInterfaces.Response:
        response.command_interfaces = [
            HardwareInterface(name=name, is_available=True) for name in self._offered
        ]
        return response

    def _on_goal(self, request: Any) -> GoalResponse:
        takes = "effort" in self._kinds and not self._old
        if said := complaint(request.trajectory, list(JOINTS), takes):
            self.get_logger().error(said)
            return GoalResponse.REJECT
        return GoalResponse.ACCEPT

    async def _execute(self, goal: Any) -> Any:
        said = "Current goal cancelled due to new incoming action."
        self._end("aborted", Result(error_code=Result.INVALID_GOAL, error_string=said))
        self._goal, self._done = goal, Future(executor=self.executor)
        self._motion = Motion(goal.request.trajectory, list(JOINTS), self._q)
        self._squares.clear()
        self._began = self._ticks * TICK
        done = self._done
        state, result = await done
        rms = 1e3 * float(np.sqrt(np.mean(self._squares))) if self._squares else 0.0
        self.get_logger().info(f"goal {state}, tracked with {rms:.4f} mrad rms")
        {"succeeded": goal.succeed, "aborted": goal.abort, "canceled": goal.canceled}[state]()
        return result

    def _end(self, state: str, result: Any) -> None:
        if self._done is not None and not self._done.done():
            self._done.set_result((state, result))
        self._goal = self._done = None

    def _hold(self) -> None:
        """Stand at the present reference, with effort 0."""
        self._motion = None

    def _catch_up(self) -> None:
        tick = TICK / self._speed
        due = int((time.monotonic() - self._start) / tick)
        for _ in range(min(due - self._ticks, 50)):
            self._step()
        # A machine that stood still is not run after.
        late = max(0, due - self._ticks) * tick
        self._start += late
        self._lost += late

    def _step(self) -> None:
        self._ticks += 1
        elapsed = self._ticks * TICK - self._began
        qd = effort = np.zeros(len(JOINTS))
        if self._goal is not None and self._goal.is_cancel_requested:
            self._end("canceled", Result(error_string="Trajectory canceled"))
            self._hold()
        if self._motion is not None:
            self._q, qd, effort = self._motion.at(elapsed)
        sample = self._arm.step(self._q, qd, effort)
        error = self._q - sample.position
        if self._ticks % 5 == 0:
            self._publish(sample)
        if self._goal is None or self._motion is None:
            return
        self._squares.append(float(np.mean(error**2)))
        if self._tolerance and np.abs(error).max() > self._tolerance:
            said = "Aborted due to path tolerance violation"
            code = Result.PATH_TOLERANCE_VIOLATED
            self._end("aborted", Result(error_code=code, error_string=said))
            self._hold()
        elif elapsed >= self._motion.duration:
            self._end("succeeded", Result(error_string="Goal successfully reached!"))
        elif self._ticks % 5 == 0:
            feedback = FollowJointTrajectory.Feedback(joint_names=list(JOINTS))
            feedback.desired.positions = self._q.tolist()
            feedback.desired.effort = effort.tolist()
            feedback.actual.positions = sample.position.tolist()
            feedback.error.positions = error.tolist()
            self._goal.publish_feedback(feedback)

    def _publish(self, sample: Any) -> None:
        state = JointState(name=list(JOINTS))
        # As a driver stamps them, by the tick; not when they are sent.
        at = self._epoch + round(1e9 * (self._lost + self._ticks * TICK / self._speed))
        state.header.stamp = Time(nanoseconds=at).to_msg()
        state.position = sample.position.tolist()
        state.velocity = sample.velocity.tolist()
        state.effort = sample.effort.tolist()
        self._states.publish(state)


def main() -> None:
    rclpy.init(args=sys.argv)
    node = Controller()
    with contextlib.suppress(KeyboardInterrupt, ExternalShutdownException):
        rclpy.spin(node)


if __name__ == "__main__":
    main()
