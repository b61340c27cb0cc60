"""The services through which a job that moves the arm is permitted to go on, or stopped."""

import threading
import time
from collections.abc import Callable

import rclpy
from rclpy.context import Context
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from std_srvs.srv import Trigger

LOOK = 0.1  # s between looks whether somebody has answered


class Desk:
    """A node in the process of a job, with two services under the name of the node that began it.

    NODE/proceed permits what is asked; NODE/abort stops the arm at once. They are there while the
    job runs.

    Args:
        node: full name of the node that began the job.
        abort: stops the arm; called in a thread.
    """

    def __init__(self, node: str, abort: Callable[[], None]) -> None:
        self._abort = abort
        self._asked, self._answer = False, threading.Event()
        self._aborted = False
        self._context = Context()
        rclpy.init(args=[], context=self._context)
        name = f"{node.rpartition('/')[2]}_permission"
        space = node.rpartition("/")[0] or "/"
        self._node = rclpy.create_node(name, namespace=space, context=self._context)
        self._node.create_service(Trigger, f"{node}/proceed", self._on_proceed)
        self._node.create_service(Trigger, f"{node}/abort", self._on_abort)
        self._executor = SingleThreadedExecutor(context=self._context)
        self._executor.add_node(self._node)
        self._thread = threading.Thread(target=self._spin, name="desk", daemon=True)
        self._thread.start()

    def ask(self, seconds: float) -> bool:
        """Return whether somebody permits it within this time."""
        self._answer.clear()
        self._asked = True
        end = time.monotonic() + seconds
        while time.monotonic() < end and not self._aborted:
            if self._answer.wait(LOOK):
                return not self._aborted
        self._asked = False
        return False

    def close(self) -> None:
        """End the node."""
        self._executor.shutdown(timeout_sec=1.0)
        self._thread.join(2.0)
        self._node.destroy_node()
        self._context.try_shutdown()

    def _spin(self) -> None:
        try:
            self._executor.spin()
        except ExternalShutdownException:
            return

    def _on_proceed(self, request: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        response.success = self._asked and not self._aborted
        response.message = "the arm goes on" if response.success else "nothing is asked now"
        if response.success:
            self._asked = False
            self._answer.set()
        return response

    def _on_abort(self, request: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        self._aborted = True
        self._abort()
        response.success = True
        response.message = "the arm is stopped, and the investigation ends with what is known"
        return response
