"""Asks the controller that goals are forwarded to what it takes."""

import importlib
import time
from collections.abc import Callable
from dataclasses import replace
from types import ModuleType
from typing import Any

from rcl_interfaces.srv import GetParameters
from rclpy.client import Client
from rclpy.node import Node

from lagrangian_ff.nodes.streaming.controller import Answers, Loaded, Verdict, judge, open_loop

PATIENCE = 2.0  # s in which a controller manager is found and answers, if there is one


def optional(module: str) -> ModuleType | None:
    """Return a package of interfaces, or None where it is not installed."""
    try:
        return importlib.import_module(module)
    except ImportError:
        return None


class ControllerFacts:
    """The last answers of a controller and of its manager.

    Args:
        name: of the controller, relative or absolute; "" if goals go on to none.
        manager: name of the controller manager.
        joints: of the model.
        heard: called when the manager has listed its controllers.
    """

    def __init__(
        self,
        node: Node,
        name: str,
        manager: str,
        joints: tuple[str, ...],
        heard: Callable[[], None],
    ) -> None:
        self._node, self._name, self._joints, self._heard = node, name, joints, heard
        self._since = time.monotonic()
        self._answers = Answers()
        self._loaded: list[Loaded] = []
        self._waiting: set[str] = set()
        self._clients: list[Client] = []
        if name:
            self._clients.append(node.create_client(GetParameters, f"{name}/get_parameters"))
        self._parameters = self._clients[0] if name else None
        self._manager: list[tuple[Client, Any, Callable[[Any], None]]] = []
        services = optional("controller_manager_msgs.srv")
        if services is not None:
            for kind, topic, note in (
                (services.ListControllers, "list_controllers", self._note_controllers),
                (services.ListHardwareInterfaces, "list_hardware_interfaces", self._note_hardware),
            ):
                client = node.create_client(kind, f"{manager}/{topic}")
                self._manager.append((client, kind, note))
                self._clients.append(client)

    def ask(self) -> None:
        """Ask again; the answers come while the node spins."""
        if self._parameters is not None:
            gains = [f"gains.{joint}.ff_velocity_scale" for joint in self._joints]
            self._ask(self._parameters, self._request("command_interfaces"), self._note_interfaces)
            self._ask(self._parameters, self._request(*gains), self._note_gains)
        for client, kind, note in self._manager:
            self._ask(client, kind.Request(), note)

    def verdict(self) -> Verdict:
        """Return whether the controller takes effort, as far as it answered."""
        return judge(self._name, self._joints, self._answers)

    def open_loop(self) -> str:
        """Return why streamed torque would move a joint that nobody controls, or ""."""
        waited = time.monotonic() - self._since
        if self._manager and self._answers.state is None and waited < PATIENCE:
            return "the controller manager was asked who controls the position"
        return open_loop(self._joints, self._loaded)

    def close(self) -> None:
        """Release the clients."""
        for client in self._clients:
            self._node.destroy_client(client)

    def _request(self, *names: str) -> GetParameters.Request:
        return GetParameters.Request(names=list(names))

    def _ask(self, client: Client, request: Any, note: Callable[[Any], None]) -> None:
        key = note.__name__
        if not client.service_is_ready():
            self._waiting.discard(key)
        elif key not in self._waiting:
            self._waiting.add(key)

            def answered(future: Any) -> None:
                self._waiting.discard(key)
                if (answer := future.result()) is not None:
                    note(answer)

            client.call_async(request).add_done_callback(answered)

    def _note_interfaces(self, answer: GetParameters.Response) -> None:
        # rclcpp answers nothing at all for a parameter that is not declared.
        found = [tuple(value.string_array_value) for value in answer.values]
        claimed = found[0] if found and found[0] else None
        self._answers = replace(self._answers, command_interfaces=claimed)

    def _note_gains(self, answer: GetParameters.Response) -> None:
        values = [value.double_value for value in answer.values]
        scale = dict(zip(self._joints, values, strict=False))
        self._answers = replace(self._answers, velocity_scale=scale)

    def _note_controllers(self, answer: Any) -> None:
        self._loaded = [
            Loaded(one.name, one.type, one.state, tuple(one.claimed_interfaces))
            for one in answer.controller
        ]
        name = self._name.rpartition("/")[2]
        found = next((one for one in answer.controller if one.name == name), None)
        claimed = tuple(found.claimed_interfaces) if found else None
        self._answers = replace(self._answers, state=found.state if found else "", claimed=claimed)
        self._heard()

    def _note_hardware(self, answer: Any) -> None:
        offered = tuple(one.name for one in answer.command_interfaces)
        self._answers = replace(self._answers, offered=offered)
