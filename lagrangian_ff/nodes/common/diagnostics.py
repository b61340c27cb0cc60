"""The state of a node on /diagnostics, once a second."""

import traceback
from collections.abc import Callable, Mapping
from functools import partial

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from rclpy.clock import Clock, ClockType
from rclpy.node import Node

from lagrangian_ff.errors import UserError
from lagrangian_ff.nodes.common.running import BAD_PARAMETER
from lagrangian_ff.nodes.common.status import Level, Status

PERIOD = 1.0


class Diagnostics:
    """Asks every task for its status once a second and publishes them together.

    What a task raises becomes its status, so that it does not silence the others. The timer runs on
    the steady clock, so that it also runs while simulated time stands still.

    Args:
        node: whose state it is; its name without the leading slash starts every status name.
        hardware_id: which machine it is about.
        tasks: name of the task to a function that tells its status.
        each: called first, once a second, for housekeeping.
        more: tasks that come and go, with their status.
    """

    def __init__(
        self,
        node: Node,
        hardware_id: str,
        tasks: Mapping[str, Callable[[], Status]],
        each: Callable[[], None] = lambda: None,
        more: Callable[[], Mapping[str, Status]] = dict,
    ) -> None:
        self._node = node
        self._name = node.get_fully_qualified_name().lstrip("/")
        self._hardware_id = hardware_id
        self._tasks = tasks
        self._each = each
        self._more = more
        self._publisher = node.create_publisher(DiagnosticArray, "/diagnostics", 10)
        self._timer = node.create_timer(
            PERIOD, self.publish, clock=Clock(clock_type=ClockType.STEADY_TIME)
        )

    def publish(self) -> None:
        """Publish the present state now."""
        told = self._asked("housekeeping", self._keep_house)
        for task, tell in self._tasks.items():
            told |= self._asked(task, partial(_alone, task, tell))
        told |= self._asked("further", self._more)
        message = DiagnosticArray()
        message.header.stamp = self._node.get_clock().now().to_msg()
        message.status = [self._status(task, status) for task, status in told.items()]
        self._publisher.publish(message)

    def _keep_house(self) -> Mapping[str, Status]:
        self._each()
        return {}

    def _asked(self, task: str, tell: Callable[[], Mapping[str, Status]]) -> dict[str, Status]:
        try:
            return dict(tell())
        except (UserError, *BAD_PARAMETER) as error:
            return {task: Status(Level.ERROR, str(error), {})}
        except Exception as error:
            self._node.get_logger().error(
                f"{task}: {traceback.format_exc()}", throttle_duration_sec=60.0
            )
            return {task: Status(Level.ERROR, f"{type(error).__name__}: {error}", {})}

    def _status(self, task: str, status: Status) -> DiagnosticStatus:
        return DiagnosticStatus(
            level=bytes([Level(status.level)]),
            name=f"{self._name}: {task}",
            message=status.message,
            hardware_id=self._hardware_id,
            values=[KeyValue(key=key, value=text) for key, text in status.texts().items()],
        )


def _alone(task: str, tell: Callable[[], Status]) -> Mapping[str, Status]:
    return {task: tell()}
