"""Nodes as real processes over DDS, and a node of the test to talk to them."""

import contextlib
import json
import os
import signal
import subprocess
import sys
import time
from collections import deque
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
import rclpy
from diagnostic_msgs.msg import DiagnosticArray
from lifecycle_msgs.srv import ChangeState, GetState
from rcl_interfaces.msg import Parameter, ParameterType, ParameterValue
from rcl_interfaces.srv import ListParameters, SetParameters
from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from ruamel.yaml import YAML

from lagrangian_ff.nodes.common.topics import PolledSubscription

PATIENCE = 60.0  # s, far more than anything takes on a loaded machine
GRACE = 5.0  # s in which a node ends by itself
RELIABLE = QoSProfile(depth=10_000, reliability=ReliabilityPolicy.RELIABLE)
BEST_EFFORT = QoSProfile(depth=2000, reliability=ReliabilityPolicy.BEST_EFFORT)
LATCHED = QoSProfile(
    depth=1, reliability=ReliabilityPolicy.RELIABLE, durability=DurabilityPolicy.TRANSIENT_LOCAL
)


def heard(*topics: str) -> dict[str, Any]:
    """Return the parameters with which a node loses no message on topics that it reads."""
    return {f"qos_overrides.{topic}.subscription.reliability": "reliable" for topic in topics}


class Process:
    """A node in its own process and session, its output in a file.

    Args:
        executable: of the package, or the name of a file beside this one.
    """

    def __init__(
        self,
        executable: str,
        log: Path,
        *,
        namespace: str = "",
        params: dict[str, Any] | None = None,
        remap: dict[str, str] | None = None,
    ) -> None:
        # The installed parameter files are what the nodes are tested with.
        file = Path(__file__).parents[2] / "config" / f"{executable}.yaml"
        arguments = ["--ros-args"]
        if file.exists():
            program = ["-m", f"lagrangian_ff.nodes.{executable}"]
            arguments += ["--params-file", str(file)]
        else:
            program = [str(Path(__file__).with_name(f"{executable}.py"))]
        if namespace:
            arguments += ["-r", f"__ns:=/{namespace}"]
        for old, new in (remap or {}).items():
            arguments += ["-r", f"{old}:={new}"]
        for name, value in (params or {}).items():
            arguments += ["-p", f"{name}:={_yaml(value)}"]
        self.log = log
        self._may_end = False
        with log.open("w") as output, _hang_up_ends():
            self._process = subprocess.Popen(
                [sys.executable, *program, *arguments],
                stdout=output,
                stderr=subprocess.STDOUT,
                start_new_session=True,
            )

    @property
    def pid(self) -> int:
        return self._process.pid

    @property
    def alive(self) -> bool:
        return self._process.poll() is None

    @property
    def broke(self) -> bool:
        """Return whether it ended without having been asked to."""
        return not self.alive and not self._may_end

    def signal(self, number: int) -> None:
        self._may_end = True
        os.killpg(self._process.pid, number)

    def wait(self) -> int:
        """Return the exit code; fail with the output if it does not end."""
        self._may_end = True
        try:
            return self._process.wait(PATIENCE)
        except subprocess.TimeoutExpired:
            raise AssertionError(f"still running:\n{self.output}") from None

    def ask_to_end(self) -> None:
        """Send SIGTERM, also to a process that is stopped."""
        with contextlib.suppress(ProcessLookupError, PermissionError):
            self.signal(signal.SIGTERM)
            self.signal(signal.SIGCONT)

    def end(self) -> None:
        """Ask it to end and wait for that; kill it if that takes too long."""
        self.ask_to_end()
        try:
            self._process.wait(GRACE)
        except subprocess.TimeoutExpired:
            self.kill()

    def kill(self) -> None:
        """Kill it if it still runs."""
        with contextlib.suppress(ProcessLookupError, PermissionError):
            self.signal(signal.SIGKILL)
        self._process.wait(PATIENCE)

    @property
    def output(self) -> str:
        return self.log.read_text(errors="replace")


def _end(processes: list[Process]) -> None:
    """Ask all to end, and wait for each."""
    # A killed process leaves broken shared memory, in which Fast DDS crashes when it next
    # writes to that process (eProsima/Fast-DDS issue 6501).
    for process in processes:
        process.ask_to_end()
    for process in processes:
        process.end()


@contextlib.contextmanager
def _hang_up_ends() -> Iterator[None]:
    """Let a process that starts now end on SIGHUP: below nohup it would inherit to ignore it."""
    before = signal.signal(signal.SIGHUP, signal.SIG_DFL)
    try:
        yield
    finally:
        signal.signal(signal.SIGHUP, before)


def _yaml(value: Any) -> str:
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(map(_yaml, value)) + "]"
    return json.dumps(value)


def configured(executable: str) -> set[str]:
    """Return the names of the parameters in the installed file of this node."""
    file = Path(__file__).parents[2] / "config" / f"{executable}.yaml"
    tree = YAML(typ="safe").load(file)["/**"]["ros__parameters"]

    def names(branch: Any, prefix: str) -> Iterator[str]:
        for key, value in branch.items():
            if isinstance(value, dict):
                yield from names(value, f"{prefix}{key}.")
            else:
                yield f"{prefix}{key}"

    return set(names(tree, ""))


SETTLED = 0.4  # s in which a service hears of its client; an answer before that is lost


class Bench:
    """A ROS node of the test, in its own context, and the processes it started."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._context = Context()
        rclpy.init(context=self._context)
        self.node = rclpy.create_node("bench", context=self._context)
        self._executor = SingleThreadedExecutor(context=self._context)
        self._executor.add_node(self.node)
        self._processes: list[Process] = []
        self._clients: dict[str, Any] = {}
        self._collected: list[tuple[PolledSubscription, deque[Any]]] = []
        self.statuses: dict[str, Any] = {}
        self.node.create_subscription(DiagnosticArray, "/diagnostics", self._on_status, 100)

    def close(self) -> None:
        _end(self._processes)
        self._executor.shutdown(timeout_sec=1.0)
        self.node.destroy_node()
        self._context.try_shutdown()

    def start(self, executable: str, **options: Any) -> Process:
        """Start a node and return at once. The options are those of Process."""
        log = self._folder / f"{executable}_{len(self._processes)}.log"
        process = Process(executable, log, **options)
        self._processes.append(process)
        return process

    @contextlib.contextmanager
    def passing(self) -> Iterator[None]:
        """End the processes that are started within."""
        before = len(self._processes)
        try:
            yield
        finally:
            _end(self._processes[before:])

    def _on_status(self, message: DiagnosticArray) -> None:
        for status in message.status:
            self.statuses[status.name] = status

    def values(self, name: str) -> dict[str, str]:
        """Return the key values of the last status of this name; empty before the first."""
        status = self.statuses.get(name)
        return {} if status is None else {pair.key: pair.value for pair in status.values}

    def spin(self, seconds: float) -> None:
        """Take messages for a while."""
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            self._take()

    def until(self, condition: Callable[[], Any], what: str, patience: float = PATIENCE) -> Any:
        """Take messages until this holds, and return its value."""
        end = time.monotonic() + patience
        while time.monotonic() < end:
            value = condition()
            if value:
                return value
            if any(process.broke for process in self._processes):
                break
            self._take()
        outputs = "\n".join(f"--- {p.log.name}\n{p.output}" for p in self._processes)
        raise AssertionError(f"waited in vain for {what}\n{outputs}")

    def until_quiet(self, queue: deque[Any], what: str, seconds: float = 0.4) -> None:
        """Take messages until a queue has got none for some time."""
        count, since = -1, 0.0

        def quiet() -> bool:
            nonlocal count, since
            if len(queue) != count:
                count, since = len(queue), time.monotonic()
            return time.monotonic() - since > seconds

        self.until(quiet, f"the end of {what}")

    def collect(self, kind: type, topic: str, qos: QoSProfile = RELIABLE) -> deque[Any]:
        """Return a queue that fills with (time received, message)."""
        queue: deque[Any] = deque(maxlen=100_000)
        self._collected.append((PolledSubscription(self.node, kind, topic, qos), queue))
        return queue

    def drop(self) -> None:
        """End the collecting of messages: at 1000 a second it takes half a processor."""
        for subscription, _ in self._collected:
            subscription.destroy()
        self._collected.clear()

    def _take(self) -> None:
        """Do one round of the executor and of the collected topics."""
        self._executor.spin_once(timeout_sec=0.01)
        for subscription, queue in self._collected:
            for message, _ in subscription.take():
                queue.append((time.monotonic(), message))

    def publisher(self, kind: type, topic: str, qos: QoSProfile = RELIABLE) -> Any:
        """Return a publisher that somebody already listens to."""
        publisher = self.node.create_publisher(kind, topic, qos)
        self.until(lambda: publisher.get_subscription_count() > 0, f"a subscriber of {topic}")
        return publisher

    def call(self, kind: Any, name: str, request: Any = None) -> Any:
        """Call a service and return its response."""
        new = name not in self._clients
        if new:
            self._clients[name] = self.node.create_client(kind, name)
        client = self._clients[name]
        self.until(client.service_is_ready, f"service {name}")
        if new:
            self.spin(SETTLED)
        future = client.call_async(kind.Request() if request is None else request)
        self.until(future.done, f"the answer of {name}")
        return future.result()

    def set_parameter(self, node: str, name: str, value: Any) -> Any:
        """Set a parameter of a running node and return the result."""
        kinds = {
            bool: ("bool_value", ParameterType.PARAMETER_BOOL),
            float: ("double_value", ParameterType.PARAMETER_DOUBLE),
            int: ("integer_value", ParameterType.PARAMETER_INTEGER),
            str: ("string_value", ParameterType.PARAMETER_STRING),
            list: ("string_array_value", ParameterType.PARAMETER_STRING_ARRAY),
        }
        field, kind = kinds[type(value)]
        parameter = Parameter(name=name, value=ParameterValue(type=kind, **{field: value}))
        request = SetParameters.Request(parameters=[parameter])
        return self.call(SetParameters, f"{node}/set_parameters", request).results[0]

    def parameters(self, node: str) -> set[str]:
        """Return the names of the declared parameters of a running node."""
        return set(self.call(ListParameters, f"{node}/list_parameters").result.names)

    def transition(self, node: str, label: str) -> bool:
        """Ask for a lifecycle transition and return whether it succeeded."""
        request = ChangeState.Request()
        request.transition.label = label
        return bool(self.call(ChangeState, f"{node}/change_state", request).success)

    def state(self, node: str) -> str:
        """Return the lifecycle state."""
        return str(self.call(GetState, f"{node}/get_state").current_state.label)


@contextlib.contextmanager
def open_bench(folder: Path, *, kills: bool = False) -> Iterator[Bench]:
    """Yield a bench that ends every process it started.

    Args:
        kills: whether processes are killed. The next write to shared memory with one may crash the
            writer, or never arrive.
    """
    with pytest.MonkeyPatch.context() as patch:
        if kills:
            patch.setenv("FASTDDS_BUILTIN_TRANSPORTS", "UDPv4")
        bench = Bench(folder)
        try:
            yield bench
        finally:
            bench.close()
