"""The demo's own ROS node: calls services, sends references, and listens."""

import time
from collections.abc import Callable
from typing import Any, TypeVar

import rclpy
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from lifecycle_msgs.srv import ChangeState
from rcl_interfaces.srv import SetParameters
from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor
from rclpy.parameter import Parameter
from std_srvs.srv import Trigger

from lagrangian_ff.demo.errors import DemoError
from lagrangian_ff.demo.processes import Nodes

T = TypeVar("T")

PATIENCE = 120.0  # s, far more than any answer takes on a busy machine


class Conductor:
    """Everything happens in the caller's thread, in `until`.

    Args:
        context: of the demo's own graph.
        nodes: watched while waiting; if one ends, so does the wait.

    Attributes:
        node: the ROS node.
    """

    def __init__(self, context: Context, nodes: Nodes) -> None:
        self.node = rclpy.create_node("conductor", context=context)
        self._executor = SingleThreadedExecutor(context=context)
        self._executor.add_node(self.node)
        self._nodes = nodes
        self._values: dict[str, dict[str, str]] = {}
        self._clients: dict[str, Any] = {}
        self._messages: dict[str, tuple[bytes, str]] = {}
        self.node.create_subscription(DiagnosticArray, "/diagnostics", self._on_status, 50)

    def close(self) -> None:
        """Leave the graph."""
        self._executor.shutdown(timeout_sec=1.0)
        self.node.destroy_node()

    def until(
        self,
        condition: Callable[[], T],
        what: str,
        patience: float = PATIENCE,
        meanwhile: Callable[[], None] = lambda: None,
    ) -> T:
        """Take messages until the condition holds; its value.

        Raises:
            DemoError: a node ended, or it did not come true in time.
        """
        deadline = time.monotonic() + patience
        look_again = 0.0
        while True:
            value = condition()
            if value:
                return value
            now = time.monotonic()
            if now > deadline:
                raise DemoError(
                    f"waited {patience:.0f} s for {what}; what the nodes said last:\n"
                    f"{self._nodes.tails()}"
                )
            if now > look_again:
                look_again = now + 0.1
                self._nodes.check()
                meanwhile()
            self._executor.spin_once(timeout_sec=0.05)

    def meet(self, kind: Any, service: str) -> None:
        """Wait for a service before it is needed: an answer may be lost between two nodes that
        have only just heard of each other."""
        if service not in self._clients:
            self._clients[service] = self.node.create_client(kind, service)
        self.until(self._clients[service].service_is_ready, f"the service {service}")

    def call(self, kind: Any, service: str, request: Any) -> Any:
        """Call a service; its response."""
        self.meet(kind, service)
        future = self._clients[service].call_async(request)
        self.until(future.done, f"an answer of {service}")
        return future.result()

    def trigger(self, service: str) -> str:
        """Call a service of type Trigger; what it says.

        Raises:
            DemoError: it refuses.
        """
        response = self.call(Trigger, service, Trigger.Request())
        if not response.success:
            raise DemoError(f"{service} refused: {response.message}")
        return str(response.message)

    def set_parameters(self, node: str, values: dict[str, object]) -> None:
        """Set parameters of a running node.

        Raises:
            DemoError: it refuses one.
        """
        request = SetParameters.Request(
            parameters=[
                Parameter(name, value=value).to_parameter_msg() for name, value in values.items()
            ]
        )
        response = self.call(SetParameters, f"{node}/set_parameters", request)
        for name, result in zip(values, response.results, strict=True):
            if not result.successful:
                raise DemoError(f"{node} refused {name} = {values[name]!r}: {result.reason}")

    def transition(self, node: str, label: str) -> bool:
        """Ask a lifecycle node for a transition; whether it was made."""
        request = ChangeState.Request()
        request.transition.label = label
        return bool(self.call(ChangeState, f"{node}/change_state", request).success)

    def status(self, name: str) -> dict[str, str]:
        """Values of the last diagnostic status of this name; empty before the first."""
        return self._values.get(name, {})

    def complaint(self, name: str) -> str:
        """What the last status of this name says if it is an error; empty otherwise."""
        level, message = self._messages.get(name, (DiagnosticStatus.OK, ""))
        return message if level == DiagnosticStatus.ERROR else ""

    def _on_status(self, message: DiagnosticArray) -> None:
        for status in message.status:
            self._values[status.name] = {pair.key: pair.value for pair in status.values}
            self._messages[status.name] = (status.level, status.message)
