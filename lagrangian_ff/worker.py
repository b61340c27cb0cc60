"""The process that does a job, seen from the program that asked for it and from inside.

A process, because compiled code that holds the interpreter would delay a recording or a page, and
because the program survives whatever happens to it. `python -m lagrangian_ff.worker JOB` writes one
JSON object a line: {"progress", "label"} while it works, {"said"} where a job calls `say`,
{"result"} or {"error"} at the end. Job and result are pickled, in hexadecimal digits. The process
ends when its standard input does, so that it does not outlive a killed program.
"""

import json
import os
import pickle
import sys
import threading
import traceback
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from subprocess import PIPE, Popen, TimeoutExpired
from typing import Any, Generic, Protocol, TypeVar

from lagrangian_ff.errors import UserError
from lagrangian_ff.progress import Progress


class Job(Protocol):
    """What can be sent to a process: it can be pickled, and so can its result."""

    def work(self, progress: Progress) -> Any:
        """Do the job and return its result.

        Args:
            progress: receives the share done, 0 to 1, and what is done now.

        Raises:
            UserError: something that the user can mend.
        """


class Listening(Job, Protocol):
    """A job that the program talks to while it works."""

    def hear(self, text: str) -> None:
        """Receive a line of `Worker.tell`; in a thread, perhaps before `work` begins."""


Given = TypeVar("Given", bound=Job)


@dataclass(frozen=True)
class Outcome:
    """The end of a job: its result, or None and the error in words."""

    result: Any
    error: str = ""


class Worker(Generic[Given]):
    """A process that does a job; the program `command` gets the job as its last argument.

    Attributes:
        job: the request.
        fraction: share done, 0 to 1.
        label: what it does now.
        said: what the job said last, see `say`; None before.
    """

    def __init__(
        self, job: Given, command: tuple[str, ...] = (sys.executable, "-m", __name__)
    ) -> None:
        self.job = job
        self.fraction = 0.0
        self.label = "starting"
        self.said: Any = None
        self._outcome: Outcome | None = None
        # A new session: the Ctrl-C that ends the program must not reach the process first.
        given = [*command, pickle.dumps(job).hex()]
        self._process = Popen(given, stdin=PIPE, stdout=PIPE, text=True, start_new_session=True)
        self._thread = threading.Thread(target=self._listen, name="worker", daemon=True)
        self._thread.start()

    def outcome(self) -> Outcome | None:
        """Return how the job ended, None before its end."""
        return None if self._thread.is_alive() else self._outcome

    def tell(self, text: str) -> None:
        """Send a line to a job that listens; nothing happens after its end."""
        assert self._process.stdin is not None
        with suppress(OSError, ValueError):  # it has ended
            self._process.stdin.write(text + "\n")
            self._process.stdin.flush()

    def cancel(self) -> None:
        """End the process now."""
        self._process.terminate()
        try:
            self._process.wait(timeout=1.0)
        except TimeoutExpired:
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
            elif "said" in event:
                self.said = event["said"]
            elif "result" in event:
                outcome = _read(event["result"])
            elif "error" in event:
                outcome = Outcome(None, str(event["error"]))
        code = self._process.wait()
        self._process.stdin.close()
        self._process.stdout.close()
        self._outcome = outcome or Outcome(
            None, f"the process ended without a result (exit code {code})"
        )


def _read(pickled: str) -> Outcome:
    try:
        return Outcome(pickle.loads(bytes.fromhex(pickled)))
    except Exception as error:  # whatever a class raises that is not what it was over there
        return Outcome(None, f"the result of the process cannot be read: {error}")


def say(record: Any) -> None:
    """Say something in JSON to the program that asked for this job; it is `Worker.said` there."""
    _write({"said": record})


def main() -> int:
    """Do the job on the command line and return the exit code."""
    os.nice(5)  # recording and control come first
    try:
        job: Job = pickle.loads(bytes.fromhex(sys.argv[1]))
        hear = getattr(job, "hear", None)
        threading.Thread(target=_end_with_its_parent, args=(hear,), daemon=True).start()
        result = job.work(lambda share, label: _write({"progress": share, "label": label}))
        pickled = pickle.dumps(result).hex()
    except (UserError, OSError) as error:
        _write({"error": str(error)})
        return 2
    except Exception as error:
        traceback.print_exc()
        _write({"error": f"unexpected {type(error).__name__}: {error}"})
        return 1
    _write({"result": pickled})
    return 0


def _write(event: dict[str, Any]) -> None:
    print(json.dumps(event), flush=True)


def _end_with_its_parent(hear: Callable[[str], None] | None) -> None:
    for line in sys.stdin:
        if hear is not None:
            hear(line.rstrip("\n"))
    os._exit(3)


if __name__ == "__main__":
    sys.exit(main())
