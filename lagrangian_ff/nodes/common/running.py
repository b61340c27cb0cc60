"""From main() to a clean end, whatever signals come."""

import signal
import sys
import threading
import traceback
from collections.abc import Callable

import rclpy
from rclpy.exceptions import (
    InvalidParameterTypeException,
    InvalidParameterValueException,
    ParameterImmutableException,
)
from rclpy.executors import SingleThreadedExecutor
from rclpy.impl.implementation_singleton import rclpy_implementation
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions
from threadpoolctl import threadpool_limits

from lagrangian_ff.errors import UserError

BAD_PARAMETER = (
    InvalidParameterTypeException,
    InvalidParameterValueException,
    ParameterImmutableException,
)


class ClosingNode(Node):
    """A node that can leave the machine in a safe state."""

    def close(self) -> None:
        """Publish last zeros, save what must be saved; the context is still valid."""


def run(make_node: Callable[[], ClosingNode], args: list[str] | None = None) -> int:
    """Run the node until SIGINT or SIGTERM; the exit code.

    rclpy's own signal handlers invalidate the context before last messages can be sent, and
    `ros2 launch` delivers SIGINT twice. So the handlers are ours: they set a flag and wake the
    executor, and during the ending both signals are ignored. An exception that escapes a
    callback is logged and the node goes on.
    """
    try:
        rclpy.init(args=args, signal_handler_options=SignalHandlerOptions.NO)
    except rclpy_implementation.RCLError as error:
        print(f"the ROS arguments cannot be used: {error}", file=sys.stderr)
        return 2
    # The paced threads share the interpreter with the executor; the default of 5 ms would
    # cost them two periods at 500 Hz.
    sys.setswitchinterval(0.0005)
    # Threads of the linear algebra spin while they wait, and would take the core of a paced loop.
    threadpool_limits(1)
    stop = threading.Event()
    executor = SingleThreadedExecutor()

    def end(signal_number: int, frame: object) -> None:
        stop.set()
        executor.wake()

    signal.signal(signal.SIGINT, end)
    signal.signal(signal.SIGTERM, end)
    node: ClosingNode | None = None
    code = 0
    try:
        node = make_node()
        executor.add_node(node)
        while not stop.is_set():
            try:
                executor.spin_once(timeout_sec=0.1)
            except Exception:
                node.get_logger().error(
                    f"a callback failed and was skipped:\n{traceback.format_exc()}",
                    throttle_duration_sec=1.0,
                )
    except (UserError, *BAD_PARAMETER) as error:
        print(f"error: {error}", file=sys.stderr, flush=True)
        code = 2
    finally:
        signal.signal(signal.SIGINT, signal.SIG_IGN)
        signal.signal(signal.SIGTERM, signal.SIG_IGN)
        if node is not None:
            node.close()
            executor.remove_node(node)
            node.destroy_node()
        executor.shutdown(timeout_sec=0.0)
        rclpy.try_shutdown()
    return code
