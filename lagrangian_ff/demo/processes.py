"""The nodes as processes of their own, which always end when the demo does."""

import contextlib
import ctypes
import os
import signal
import subprocess
import sys
import time
from collections.abc import Mapping, Sequence
from pathlib import Path
from types import TracebackType

from lagrangian_ff.demo.errors import DemoError

PATIENCE = 5.0  # s for a node to end after SIGINT
TAIL = 15  # lines of a log that are shown

# Looked up before any fork: between fork and exec as little as possible may happen.
_PRCTL = ctypes.CDLL(None).prctl if sys.platform == "linux" else None
_PR_SET_PDEATHSIG = 1


class NodeProcess:
    """One node in a session of its own, its output in a file.

    Args:
        name: of the executable, a module of lagrangian_ff.nodes.
        log: file for its output.
        parameters: ROS parameters by name.
        remap: topics or names, from and to.
        environment: of the process.
    """

    def __init__(
        self,
        name: str,
        log: Path,
        *,
        parameters: Mapping[str, object],
        remap: Mapping[str, str],
        environment: Mapping[str, str],
    ) -> None:
        self.name = log.stem
        self.log = log
        arguments = ["--ros-args"]
        for old, new in remap.items():
            arguments += ["-r", f"{old}:={new}"]
        for key, value in parameters.items():
            arguments += ["-p", f"{key}:={_yaml(value)}"]
        # Not the executable's name: `identify` is also ImageMagick's.
        command = [sys.executable, "-m", f"lagrangian_ff.nodes.{name}", *arguments]
        with log.open("wb") as file:
            self._process = subprocess.Popen(
                command,
                stdin=subprocess.DEVNULL,
                stdout=file,
                stderr=subprocess.STDOUT,
                env=dict(environment),
                start_new_session=True,
                preexec_fn=_end_with_parent if _PRCTL else None,
            )
        self.peak = 0

    @property
    def number(self) -> int:
        """Of the process."""
        return self._process.pid

    @property
    def alive(self) -> bool:
        """Whether it still runs."""
        return self._process.poll() is None

    def check(self) -> None:
        """Raise DemoError with the end of its log if it has ended."""
        if not self.alive:
            raise DemoError(
                f"the node {self.name} ended by itself (exit code {self._process.returncode}); "
                f"the end of {self.log}:\n{self.tail()}"
            )

    def tail(self) -> str:
        """The last lines of its log."""
        lines = self.log.read_text(encoding="utf-8", errors="replace").splitlines()
        return "\n".join(f"  {line}" for line in lines[-TAIL:]) or "  (nothing was printed)"

    def measure(self) -> int:
        """Bytes of memory it held at most, 0 where the system does not tell."""
        with contextlib.suppress(OSError, StopIteration, ValueError):
            status = Path(f"/proc/{self._process.pid}/status").read_text()
            line = next(line for line in status.splitlines() if line.startswith("VmHWM:"))
            self.peak = max(self.peak, 1024 * int(line.split()[1]))
        return self.peak

    def signal(self, number: int) -> None:
        """Send a signal to the whole session."""
        with contextlib.suppress(ProcessLookupError, PermissionError):
            os.killpg(self._process.pid, number)

    def wait(self, seconds: float) -> bool:
        """Whether it has ended within this time."""
        try:
            self._process.wait(max(0.0, seconds))
        except subprocess.TimeoutExpired:
            return False
        return True


class Nodes:
    """All processes of a demo; leaving the context ends them, whatever happened.

    Args:
        logs: folder for their output.
        environment: of the processes.
    """

    def __init__(self, logs: Path, environment: Mapping[str, str]) -> None:
        self._logs = logs
        self._environment = environment
        self._running: list[NodeProcess] = []
        self._peaks: dict[str, int] = {}

    def start(
        self,
        executable: str,
        *,
        parameters: Mapping[str, object] | None = None,
        remap: Mapping[str, str] | None = None,
        log: str | None = None,
    ) -> NodeProcess:
        """Start a node; returns at once."""
        process = NodeProcess(
            executable,
            self._logs / f"{log or executable}.log",
            parameters=parameters or {},
            remap=remap or {},
            environment=self._environment,
        )
        self._running.append(process)
        return process

    def check(self) -> None:
        """Raise DemoError if one has ended."""
        for process in self._running:
            process.check()

    def peaks(self) -> dict[str, int]:
        """Bytes of memory each held at most."""
        self._peaks |= {process.name: process.measure() for process in self._running}
        return dict(self._peaks)

    def numbers(self) -> list[int]:
        """Of the processes that were not ended."""
        return [process.number for process in self._running]

    def tails(self) -> str:
        """The end of every log."""
        return "\n".join(f"{process.log}:\n{process.tail()}" for process in self._running)

    def end(self, *names: str) -> None:
        """Ask these to end, then make them.

        Args:
            names: as in `peaks`; none for all.
        """
        self.peaks()
        ending = [process for process in self._running if not names or process.name in names]
        self._running = [process for process in self._running if process not in ending]
        _end(ending)

    def __enter__(self) -> "Nodes":
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.end()


def _end(processes: Sequence[NodeProcess]) -> None:
    for number, patience in ((signal.SIGINT, PATIENCE), (signal.SIGTERM, 1.0)):
        for process in processes:
            if process.alive:
                process.signal(number)
        deadline = time.monotonic() + patience
        for process in processes:
            process.wait(deadline - time.monotonic())
    for process in processes:
        if process.alive:
            process.signal(signal.SIGKILL)
            process.wait(PATIENCE)


def _end_with_parent() -> None:
    """Let the kernel end this process when the demo dies without a word (SIGKILL)."""
    assert _PRCTL is not None
    _PRCTL(_PR_SET_PDEATHSIG, signal.SIGTERM)


def _yaml(value: object) -> str:
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(map(_yaml, value)) + "]"
    return f'"{value}"' if isinstance(value, str) else str(value)
