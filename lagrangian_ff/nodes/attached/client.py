"""The process in the graph, `nodes/live.py`, as a program without ROS starts it and asks it."""

import json
import subprocess
import sys
import threading
import time
from collections import deque
from collections.abc import Callable, Sequence
from contextlib import suppress
from importlib.util import find_spec
from typing import Any

from lagrangian_ff.errors import UserError

PROGRAM = ("-m", "lagrangian_ff.nodes.live")
PATIENCE = 15.0  # s for an answer
STARTING = 30.0  # s until the process has heard of the robot
FINDING = 15.0  # s until it has heard of who listens
ENDING = 10.0  # s for the process to end: it may have a motion to stop
LATE = 5.0  # s in which joints that are asked for are heard of
SETTLED = 1.0  # s without another joint, after which all are heard of
LOOK = 0.05  # s between looks

Told = dict[str, Any]


class Client:
    """The process and the newest of what it says. It ends with this program, however that ends.

    Waiting looks again and again instead of being woken: a signal's handler may interrupt it, and
    must find no lock taken.

    Args:
        arguments: of ROS, for the process, such as ("--ros-args", "-r", "joint_states:=/NAME").

    Attributes:
        status: the newest; empty before the first.
        at: s of the monotonic clock when that came.

    Raises:
        UserError: ROS is not there.
    """

    def __init__(self, arguments: Sequence[str] = ()) -> None:
        if find_spec("rclpy") is None:
            raise UserError("rclpy is not there: source ROS 2 in this shell first")
        self.arguments = tuple(arguments)
        self.status: Told = {}
        self.at = time.monotonic()
        self._answers: dict[int, Told] = {}
        self._number = 0
        self._log: deque[str] = deque(maxlen=20)
        # A new session: Ctrl-C in the terminal must not reach the process.
        self._process = subprocess.Popen(
            [sys.executable, *PROGRAM, *self.arguments],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            start_new_session=True,
        )
        for listen in (self._listen, self._keep_log):
            threading.Thread(target=listen, name=listen.__name__, daemon=True).start()

    @property
    def pid(self) -> int:
        """Return the number of the process."""
        return self._process.pid

    @property
    def alive(self) -> bool:
        """Return whether the process runs."""
        return self._process.poll() is None

    @property
    def last_words(self) -> str:
        """Return the last line that the process logged, or how it ended."""
        return self._log[-1] if self._log else f"exit code {self._process.poll()}"

    def ask(self, do: str, **asked: Any) -> Told:
        """Return the answer to a command.

        Raises:
            UserError: it was refused, the process has ended, or it does not answer.
        """
        self._number += 1
        number = self._number
        line = json.dumps({"id": number, "do": do, **asked}) + "\n"
        assert self._process.stdin is not None
        with suppress(OSError):  # it has ended: said below
            self._process.stdin.write(line.encode())
            self._process.stdin.flush()
        found: Told = self.wait(lambda: self._answers.pop(number, None), PATIENCE, f"answer {do}")
        if "error" in found:
            raise UserError(str(found["error"]))
        return found

    def wait(self, found: Callable[[], Any], patience: float, what: str) -> Any:
        """Return what is found as soon as that is not None.

        Raises:
            UserError: the process has ended, or does not do so in time.
        """
        end = time.monotonic() + patience
        while True:
            alive = self.alive
            if (value := found()) is not None:
                return value
            if not alive:
                raise UserError(f"the process in the ROS graph has ended: {self.last_words}")
            if time.monotonic() > end:
                raise UserError(f"the process in the ROS graph does not {what}")
            time.sleep(LOOK)

    def joints(self) -> tuple[str, ...]:
        """Return the names of the joints that are heard of, once there are any.

        Raises:
            UserError: none are heard of.
        """
        try:
            return tuple(
                self.wait(lambda: self.status.get("joints") or None, STARTING, "hear joint states")
            )
        except UserError as error:
            if not self.alive or not self.status:
                raise
            topic = self.status.get("topic", "joint_states")
            raise UserError(f"no joint states on {topic}: start the driver, or name it") from error

    def every_joint(self, wanted: Sequence[str]) -> tuple[str, ...]:
        """Return the names of all joints that are heard of, once no other joins them for a while.

        An arm and its gripper may have a driver each.

        Args:
            wanted: names that are waited for some seconds longer.

        Raises:
            UserError: as by `joints`.
        """
        found, changed = self.joints(), time.monotonic()
        end = changed + LATE
        while time.monotonic() < (end if set(wanted) - set(found) else changed + SETTLED):
            time.sleep(LOOK)
            if (now := self.joints()) != found:
                found, changed = now, time.monotonic()
        return found

    def listeners(self, topic: str) -> tuple[str, ...]:
        """Return the nodes that take trajectories from a topic.

        Raises:
            UserError: there are none; names the topics that there are.
        """

        def found() -> tuple[str, ...] | None:
            known = self.status.get("topics", ())
            return next((tuple(one["nodes"]) for one in known if one["topic"] == topic), None)

        try:
            return tuple(self.wait(found, FINDING, f"find {topic}"))
        except UserError:
            if not self.alive:
                raise
            known = ", ".join(one["topic"] for one in self.status.get("topics", ()))
            raise UserError(
                f"nobody takes trajectories from {topic}; there are: {known or 'no such topics'}"
            ) from None

    def takes(self, topic: str) -> tuple[str, ...]:
        """Return the joints of the controller that takes trajectories; none if it does not say."""
        return tuple(self.ask("takes", topic=topic)["joints"])

    def close(self) -> None:
        """End the process: it stops its motion and closes its recording."""
        assert self._process.stdin is not None
        with suppress(OSError):
            self._process.stdin.close()
        try:
            self._process.wait(ENDING)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()

    def _listen(self) -> None:
        assert self._process.stdout is not None
        for line in self._process.stdout:
            try:
                event = json.loads(line)
            except ValueError:
                continue  # a library that prints
            if not isinstance(event, dict):
                continue
            if "answer" in event:
                self._answers[int(event["answer"])] = event
            elif event.get("event") == "status":
                self.status, self.at = event, time.monotonic()

    def _keep_log(self) -> None:
        assert self._process.stderr is not None
        for line in self._process.stderr:
            if text := line.decode(errors="replace").strip():
                self._log.append(text)
