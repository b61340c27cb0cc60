"""The frame of every node: clean start and end, parameters, and its state on /diagnostics."""

import signal
import sys
import time
import traceback
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import rclpy
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from lifecycle_msgs.srv import ChangeState
from rcl_interfaces.msg import (
    FloatingPointRange,
    IntegerRange,
    ParameterDescriptor,
    SetParametersResult,
)
from rclpy.clock import Clock, ClockType
from rclpy.exceptions import (
    InvalidParameterTypeException,
    InvalidParameterValueException,
    ParameterImmutableException,
)
from rclpy.executors import SingleThreadedExecutor
from rclpy.impl.implementation_singleton import rclpy_implementation
from rclpy.lifecycle import LifecycleNode
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.signals import SignalHandlerOptions
from rclpy.task import Future
from rclpy.utilities import remove_ros_args

import lagrangian_ff
from lagrangian_ff.errors import UserError
from lagrangian_ff.kernels.threads import one_blas_thread
from lagrangian_ff.nodes.common.log_folder import use_writable_log_folder
from lagrangian_ff.nodes.common.profiles import read_profile
from lagrangian_ff.nodes.common.status import Level, Status

BAD_PARAMETER = (
    InvalidParameterTypeException,
    InvalidParameterValueException,
    ParameterImmutableException,
)

PACKAGE = Path(lagrangian_ff.__file__).parent

ENDING = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGQUIT)
"""The signals that end a node cleanly: Ctrl-C, ROS, a terminal that is closed, Ctrl-\\."""

ANSWERS = 1.0
"""Seconds for which the end of a node waits for answers."""


class ClosingNode(Node):
    """A node that can leave the machine in a safe state."""

    unanswered: Sequence[Future] = ()
    """Answers that `close` waits for: if the node ends first, its requests may never arrive."""

    def close(self) -> None:
        """Publish last zeros and save what must be saved; the context is still valid."""


def run(make_node: Callable[[], ClosingNode], args: list[str] | None = None) -> int:
    """Run the node until a signal of `ENDING` comes and return the exit code.

    rclpy's own signal handlers invalidate the context before last messages can be sent, and
    `ros2 launch` delivers SIGINT twice. So the handlers are ours: they set a flag and wake the
    executor, and during the ending the signals are ignored. An exception that escapes a
    callback is logged and the node goes on.
    """
    answered = _answer(make_node, sys.argv if args is None else args)
    if answered is not None:
        return answered
    use_writable_log_folder()
    try:
        rclpy.init(args=args, signal_handler_options=SignalHandlerOptions.NO)
    except rclpy_implementation.RCLError as error:
        print(f"the ROS arguments cannot be used: {error}", file=sys.stderr)
        return 2
    # The paced threads share the interpreter with the executor; the default of 5 ms would
    # cost them two periods at 500 Hz.
    sys.setswitchinterval(0.0005)
    # Threads of the linear algebra spin while they wait, and would take the core of a paced loop.
    one_blas_thread()
    stop = False
    executor = SingleThreadedExecutor()

    def end(signal_number: int, frame: object) -> None:
        # No lock here: a second signal may interrupt this one in the same thread.
        nonlocal stop
        stop = True
        executor.wake()

    def spin_once(node: ClosingNode) -> None:
        try:
            executor.spin_once(timeout_sec=0.1)
        except Exception as error:
            said = f"a callback failed and was skipped: {_reason(error)}"
            node.get_logger().error(said, throttle_duration_sec=1.0)

    for number in ENDING:
        # nohup leaves the hang-up ignored; a shell's background leaves Ctrl-C so, but not launch's.
        if number != signal.SIGHUP or signal.getsignal(number) != signal.SIG_IGN:
            signal.signal(number, end)
    node: ClosingNode | None = None
    code = 0
    try:
        node = make_node()
        executor.add_node(node)
        while not stop:
            spin_once(node)
    except (UserError, *BAD_PARAMETER) as error:
        print(f"error: {error}", file=sys.stderr, flush=True)
        code = 2
    finally:
        for number in ENDING:
            signal.signal(number, signal.SIG_IGN)
        if node is not None:
            node.close()
            deadline = time.monotonic() + ANSWERS
            while time.monotonic() < deadline and not all(f.done() for f in node.unanswered):
                spin_once(node)
            executor.remove_node(node)
            node.destroy_node()
        executor.shutdown(timeout_sec=0.0)
        rclpy.try_shutdown()
    return code


def _answer(make_node: Callable[[], ClosingNode], args: list[str]) -> int | None:
    """Answer --help and what is no argument of ROS; return the exit code, or None to go on."""
    name = Path(args[0]).stem
    own = remove_ros_args(args)[1:]
    if not own:
        return None
    usage = f"usage: ros2 run lagrangian_ff {name} [--ros-args -p PARAMETER:=VALUE ...]"
    if any(word in ("-h", "--help") for word in own):
        print(f"{usage}\n\n{(sys.modules[make_node.__module__].__doc__ or '').strip()}\n")
        print(f"config/{name}.yaml describes the parameters; so does `ros2 param describe`.")
        return 0
    print(
        f"error: {' '.join(own)} is no argument of {name}; parameters come after --ros-args\n"
        f"{usage}",
        file=sys.stderr,
    )
    return 2


def _reason(error: Exception) -> str:
    """Return the traceback of an error in this package; a line for a message rclpy cannot take."""
    frames = traceback.extract_tb(error.__traceback__)[1:]  # the first is that of `run`
    if any(Path(frame.filename).is_relative_to(PACKAGE) for frame in frames):
        return "\n" + "".join(traceback.format_exception(error))
    return f"{type(error).__name__}: {error}"


def answer_every_transition(node: LifecycleNode) -> None:
    """Answer requests for transitions that are impossible now: success false, the reason logged.

    rclpy's `~/change_state` raises on the id of such a transition, and a service that raises never
    answers: its clients would wait for ever. (A label that is impossible it answers itself.)
    """
    topic = node.resolve_service_name("~/change_state")
    service = next(one for one in node.services if one.srv_name == topic)
    change_state = service.callback

    def answer(
        request: ChangeState.Request, response: ChangeState.Response
    ) -> ChangeState.Response:
        try:
            return change_state(request, response)
        except rclpy_implementation.RCLError:
            wanted, machine = request.transition, node._state_machine
            possible = ", ".join(
                f"{found[1]} ({found[0]})" for found in machine.available_transitions
            )
            node.get_logger().warning(
                f"refused transition {wanted.label or wanted.id}: the node is "
                f"{machine.current_state[1]}; possible now: {possible or 'none'}"
            )
            response.success = False
            return response

    service.callback = answer


class Parameters:
    """The declared parameters of a node; a value that is not allowed is refused with a reason.

    Args:
        profiles: whether there is a parameter `profile`, whose values go before the defaults.

    Raises:
        UserError: there is no such profile.
    """

    def __init__(self, node: Node, *, profiles: bool = False) -> None:
        self._node = node
        self._profile: dict[str, Any] = {}
        self._choices: dict[str, tuple[str, ...]] = {}
        self._checks: dict[str, Callable[[Any], str]] = {}
        self._declaring = False
        node.add_on_set_parameters_callback(self._check)
        if profiles:
            about = "name of a file in config/arms, or a path: parameters for a driver"
            self._profile = read_profile(self.declare("profile", "", about, read_only=True))

    def watch(self, changed: Callable[[], None]) -> None:
        """Call `changed` now, and whenever parameters were set at run time."""

        def after(parameters: list[Parameter]) -> None:
            if not self._declaring:
                changed()

        self._node.add_post_set_parameters_callback(after)
        changed()

    def declare(
        self,
        name: str,
        default: Any,
        description: str,
        *,
        low: float | None = None,
        high: float | None = None,
        choices: Sequence[str] = (),
        read_only: bool = False,
        check: Callable[[Any], str] = lambda value: "",
    ) -> Any:
        """Declare a parameter and return its value.

        Args:
            name: snake_case, nested with dots.
            default: its type is the type of the parameter.
            description: what it does, with the unit.
            low, high: smallest and largest value; each needs the other.
            choices: the only texts allowed.
            read_only: can be set at the start only.
            check: returns why a value is not allowed, or "".

        Raises:
            InvalidParameterValueException, InvalidParameterTypeException: of rclpy; the value
                given at the start is not allowed. `run` prints it.
        """
        if self._node.has_parameter(name):
            return self.value(name)
        if name in self._profile:
            given = self._profile[name]
            default = type(default)(given) if isinstance(default, float) else given
        descriptor = ParameterDescriptor(description=description, read_only=read_only)
        if low is not None and high is not None:
            if isinstance(default, int):
                descriptor.integer_range = [IntegerRange(from_value=int(low), to_value=int(high))]
            else:
                descriptor.floating_point_range = [
                    FloatingPointRange(from_value=float(low), to_value=float(high))
                ]
        if choices:
            descriptor.additional_constraints = f"one of: {', '.join(choices)}"
            # YAML reads an unquoted `true` as a boolean; it still names the choice.
            descriptor.dynamic_typing = "true" in choices
            self._choices[name] = tuple(choices)
        self._checks[name] = check
        self._declaring = True
        try:
            return self._plain(name, self._node.declare_parameter(name, default, descriptor).value)
        finally:
            self._declaring = False

    def declare_effort(self, joints: Sequence[str]) -> None:
        """Declare the conversion from effort to N·m of each joint."""
        for joint in joints:
            for name, default, description in (
                ("effort_scale", 1.0, "N·m per unit of effort"),
                ("effort_offset", 0.0, "N·m added after scaling"),
            ):
                self.declare(f"{name}.{joint}", default, description, low=-1e6, high=1e6)

    def refuse_unknown(self, *groups: str) -> None:
        """Raise UserError if a parameter of these groups was given that is none, as a typo."""
        for name in self._node._parameter_overrides:
            group = name.partition(".")[0]
            if group in groups and not self._node.has_parameter(name):
                known = sorted(self._node.get_parameters_by_prefix(group))
                raise UserError(
                    f"there is no parameter {name}; below {group} there are "
                    f"{', '.join(known) or 'none'}"
                )

    def value(self, name: str) -> Any:
        """Return the present value."""
        return self._plain(name, self._node.get_parameter(name).value)

    def strings(self, name: str) -> tuple[str, ...]:
        """Return the present value of a list of texts, without empty ones.

        ROS does not know the type of an empty list, so [""] stands for it.
        """
        return tuple(text for text in self.value(name) if text)

    def _plain(self, name: str, value: Any) -> Any:
        return str(value).lower() if name in self._choices else value

    def _check(self, parameters: list[Parameter]) -> SetParametersResult:
        for parameter in parameters:
            allowed = self._choices.get(parameter.name)
            value = self._plain(parameter.name, parameter.value)
            if allowed is not None and value not in allowed:
                reason = f"{parameter.name} is {value!r}; expected one of {', '.join(allowed)}"
                return SetParametersResult(successful=False, reason=reason)
            refusal = self._checks[parameter.name](value) if parameter.name in self._checks else ""
            if refusal:
                return SetParametersResult(successful=False, reason=refusal)
        return SetParametersResult(successful=True)


def _namesake(node: Node) -> str:
    """Return that another node has the same name and what to do, or ""."""
    names = [(ns, name) for name, ns in node.get_node_names_and_namespaces()]
    count = names.count((node.get_namespace(), node.get_name()))
    if count < 2:
        return ""
    return (
        f"{count} nodes are called {node.get_fully_qualified_name()}: services and parameters "
        "reach any of them; end one, or start it with -r __node:=NAME or -r __ns:=/NAMESPACE "
        "(a killed one is listed for 20 s more)"
    )


class Diagnostics:
    """Publishes the status of every part of a node once a second.

    An exception in one part becomes its status and does not silence the others. The timer runs on
    the steady clock, so that it also runs while simulated time stands still.

    Args:
        node: its name without the leading slash starts every status name.
        hardware_id: the machine that the state is about.
        parts: by name, called in order; each returns its status, several statuses by name, or
            None for housekeeping.
    """

    def __init__(
        self,
        node: Node,
        hardware_id: str,
        **parts: Callable[[], Status | Mapping[str, Status] | None],
    ) -> None:
        self._node = node
        self._name = node.get_fully_qualified_name().lstrip("/")
        self._hardware_id, self._parts = hardware_id, parts
        self._publisher = node.create_publisher(DiagnosticArray, "/diagnostics", 10)
        self._timer = node.create_timer(
            1.0, self.publish, clock=Clock(clock_type=ClockType.STEADY_TIME)
        )

    def publish(self) -> None:
        """Publish the present state now."""
        statuses: dict[str, Status] = {}
        for part, ask in self._parts.items():
            try:
                found = ask()
            except (UserError, *BAD_PARAMETER) as error:
                found = Status(Level.ERROR, str(error))
            except Exception as error:
                said = f"{part}: {traceback.format_exc()}"
                self._node.get_logger().error(said, throttle_duration_sec=60.0)
                found = Status(Level.ERROR, f"{type(error).__name__}: {error}")
            statuses |= {part: found} if isinstance(found, Status) else found or {}
        if namesake := _namesake(self._node):
            statuses["name"] = Status(Level.WARN, namesake)
        self.send(statuses)

    def send(self, statuses: Mapping[str, Status]) -> None:
        """Publish these statuses by part now, from any thread: what cannot wait for the timer."""
        message = DiagnosticArray()
        message.header.stamp = self._node.get_clock().now().to_msg()
        message.status = [self._message(part, status) for part, status in statuses.items()]
        self._publisher.publish(message)

    def _message(self, part: str, status: Status) -> DiagnosticStatus:
        return DiagnosticStatus(
            level=bytes([Level(status.level)]),
            name=f"{self._name}: {part}",
            message=status.message,
            hardware_id=self._hardware_id,
            values=[KeyValue(key=key, value=text) for key, text in status.texts().items()],
        )
