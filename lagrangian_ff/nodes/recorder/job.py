"""The work under way, seen from the node."""

import json
import subprocess
import sys
import threading
from dataclasses import dataclass
from typing import Any

from lagrangian_ff.nodes.recorder.order import Order

MODULE = "lagrangian_ff.nodes.recorder.work"


@dataclass(frozen=True)
class Outcome:
    """How it ended: a record, or an error in words."""

    record: dict[str, Any] | None
    error: str = ""


class Job:
    """A process that carries out an order.

    Args:
        order: what to do.
        command: the program; it gets the order as its last argument and speaks the protocol of
            `work`.

    Attributes:
        order: what it does.
        fraction: done so far, 0 to 1.
        label: what it does now.
    """

    def __init__(
        self, order: Order, command: tuple[str, ...] = (sys.executable, "-m", MODULE)
    ) -> None:
        self.order = order
        self.fraction = 0.0
        self.label = "starting"
        self._outcome: Outcome | None = None
        # A session of its own: the Ctrl-C that ends the node must not reach it first.
        self._process = subprocess.Popen(
            [*command, order.to_json()],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
            start_new_session=True,
        )
        self._thread = threading.Thread(target=self._listen, name="job", daemon=True)
        self._thread.start()

    def outcome(self) -> Outcome | None:
        """How it ended, None while it has not."""
        return None if self._thread.is_alive() else self._outcome

    def cancel(self) -> None:
        """End it now."""
        self._process.terminate()
        try:
            self._process.wait(timeout=1.0)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()
        self._thread.join(timeout=1.0)

    def _listen(self) -> None:
        assert self._process.stdout is not None
        assert self._process.stdin is not None
        outcome: Outcome | None = None
        for line in self._process.stdout:
            try:
                event = json.loads(line)
            except ValueError:
                continue  # a library that prints
            if not isinstance(event, dict):
                continue  # a number that it prints
            if "progress" in event:
                self.fraction, self.label = float(event["progress"]), str(event["label"])
            elif "result" in event:
                outcome = Outcome(event["result"])
            elif "error" in event:
                outcome = Outcome(None, str(event["error"]))
        code = self._process.wait()
        self._process.stdin.close()
        self._process.stdout.close()
        self._outcome = outcome or Outcome(
            None, f"the process ended without a result (exit code {code})"
        )
