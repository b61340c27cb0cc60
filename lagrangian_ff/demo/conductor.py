"""The demo's own ROS graph, and its node in it: calls services, sends references, listens.

The graph is on this machine only, in a domain without other nodes.
"""

import os
import random
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any, TypeVar

import rclpy
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from lifecycle_msgs.srv import ChangeState
from rcl_interfaces.srv import SetParameters
from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor
from rclpy.parameter import Parameter
from rclpy.signals import SignalHandlerOptions
from std_srvs.srv import Trigger

from lagrangian_ff.demo.processes import Nodes
from lagrangian_ff.errors import DemoError

T = TypeVar("T")

PATIENCE = 120.0  # s, far more than any answer takes on a busy machine
DOMAINS = range(1, 102)  # above, DDS's ports may meet those that Linux gives out
LISTEN = 0.8  # s in which the nodes of a domain make themselves known
TRIES = 8  # domains
LOCAL = {"ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST", "ROS_STATIC_PEERS": ""}


class Conductor:
    """The demo's node; all its work is done in the caller's thread, in `until`.

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
        self._clients: dict[str, Any] = {}
        self._status: dict[str, DiagnosticStatus] = {}
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
        """Take messages until the condition holds; return its value.

        Raises:
            DemoError: a node ended, or the condition did not hold in time.
        """
        deadline, look_again = time.monotonic() + patience, 0.0
        while not (value := condition()):
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
        return value

    def meet(self, kind: Any, service: str) -> None:
        """Wait for a service ahead of use: two nodes that have just met may lose an answer."""
        if service not in self._clients:
            self._clients[service] = self.node.create_client(kind, service)
        self.until(self._clients[service].service_is_ready, f"the service {service}")

    def call(self, kind: Any, service: str, request: Any) -> Any:
        """Call a service; return its response."""
        self.meet(kind, service)
        future = self._clients[service].call_async(request)
        self.until(future.done, f"an answer of {service}")
        return future.result()

    def trigger(self, service: str) -> str:
        """Call a service of type Trigger; return its message, or raise DemoError if it refuses."""
        response = self.call(Trigger, service, Trigger.Request())
        if not response.success:
            raise DemoError(f"{service} refused: {response.message}")
        return str(response.message)

    def set_parameters(self, node: str, values: dict[str, object]) -> None:
        """Set parameters of a running node; raise DemoError if it refuses one."""
        made = [Parameter(name, value=value).to_parameter_msg() for name, value in values.items()]
        request = SetParameters.Request(parameters=made)
        response = self.call(SetParameters, f"{node}/set_parameters", request)
        for name, result in zip(values, response.results, strict=True):
            if not result.successful:
                raise DemoError(f"{node} refused {name} = {values[name]!r}: {result.reason}")

    def transition(self, node: str, label: str) -> bool:
        """Ask a lifecycle node for a transition; return whether it was made."""
        request = ChangeState.Request()
        request.transition.label = label
        return bool(self.call(ChangeState, f"{node}/change_state", request).success)

    def status(self, name: str) -> dict[str, str]:
        """Return the values of the last diagnostic status of this name; empty before the first."""
        last = self._status.get(name)
        return {pair.key: pair.value for pair in last.values} if last else {}

    def complaint(self, name: str) -> str:
        """Return the message of the last status of this name if it is an error, else nothing."""
        last = self._status.get(name)
        return str(last.message) if last and last.level == DiagnosticStatus.ERROR else ""

    def _on_status(self, message: DiagnosticArray) -> None:
        self._status |= {status.name: status for status in message.status}


@contextmanager
def own_graph(domain: int | None) -> Iterator[tuple[Context, int]]:
    """Yield a context in its own domain, and the number of that domain.

    Args:
        domain: the domain to use; None looks for one without nodes.

    Raises:
        DemoError: all domains that were tried have nodes.
    """
    before = {name: os.environ.get(name) for name in LOCAL}
    os.environ.update(LOCAL)
    try:
        context, domain = (_join(domain), domain) if domain is not None else _find()
        try:
            yield context, domain
        finally:
            context.try_shutdown()
    finally:
        for name, value in before.items():
            if value is None:
                os.environ.pop(name, None)
            else:
                os.environ[name] = value


def _join(domain: int) -> Context:
    context = Context()
    # Ctrl-C must reach the demo as KeyboardInterrupt, so that it ends its nodes.
    rclpy.init(
        args=[], context=context, domain_id=domain, signal_handler_options=SignalHandlerOptions.NO
    )
    return context


def _find() -> tuple[Context, int]:
    for domain in random.SystemRandom().sample(DOMAINS, TRIES):
        context = _join(domain)
        node = rclpy.create_node("lagrangian_ff_demo_scout", context=context)
        time.sleep(LISTEN)
        others = [name for name in node.get_node_names() if name != node.get_name()]
        node.destroy_node()
        if not others:
            return context, domain
        context.try_shutdown()
    raise DemoError(f"{TRIES} ROS domains were tried and all have nodes; give one with --domain")
