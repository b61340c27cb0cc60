"""The nodes as separate processes, which end with the demo, and the processor time they take."""

import contextlib
import ctypes
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path

from lagrangian_ff.errors import DemoError

PATIENCE = 5.0  # s for a node to end after SIGINT
TAIL = 15  # lines of a log that are shown
BUSY = 8  # columns of /proc/stat: user, nice, system, idle, iowait, irq, softirq, steal
IDLE = (3, 4)

# Looked up before any fork: between fork and exec as little as possible may happen.
_PRCTL = ctypes.CDLL(None).prctl if sys.platform == "linux" else None
_PR_SET_PDEATHSIG = 1


class NodeProcess:
    """One node in its own session, with its output in a file.

    Args:
        name: of the executable, a module of lagrangian_ff.nodes.
        logs: folder for its output.
        parameters: ROS parameters by name.
        remap: topics or names, from and to.
    """

    def __init__(
        self,
        name: str,
        logs: Path,
        *,
        parameters: Mapping[str, object],
        remap: Mapping[str, str],
        environment: Mapping[str, str],
    ) -> None:
        self.name, self.log = name, logs / f"{name}.log"
        arguments = ["--ros-args"]
        for old, new in remap.items():
            arguments += ["-r", f"{old}:={new}"]
        for key, value in parameters.items():
            arguments += ["-p", f"{key}:={_yaml(value)}"]
        # Not the executable's name: `identify` is also ImageMagick's.
        command = [sys.executable, "-m", f"lagrangian_ff.nodes.{name}", *arguments]
        with self.log.open("wb") as file:
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
        """Return the process id."""
        return self._process.pid

    @property
    def alive(self) -> bool:
        """Return whether it still runs."""
        return self._process.poll() is None

    def check(self) -> None:
        """Raise DemoError with the end of its log if it has ended."""
        if not self.alive:
            raise DemoError(
                f"the node {self.name} ended by itself (exit code {self._process.returncode}); "
                f"the end of {self.log}:\n{self.tail()}"
            )

    def tail(self) -> str:
        """Return the last lines of its log."""
        lines = self.log.read_text(encoding="utf-8", errors="replace").splitlines()
        return "\n".join(f"  {line}" for line in lines[-TAIL:]) or "  (nothing was printed)"

    def measure(self) -> int:
        """Return the most memory it has held, bytes; 0 if the system does not report it."""
        with contextlib.suppress(OSError, StopIteration, ValueError):
            status = Path(f"/proc/{self._process.pid}/status").read_text()
            line = next(line for line in status.splitlines() if line.startswith("VmHWM:"))
            self.peak = max(self.peak, 1024 * int(line.split()[1]))
        return self.peak

    def signal(self, number: int) -> None:
        """Send a signal to the whole session while it runs."""
        with contextlib.suppress(ProcessLookupError, PermissionError):
            if self.alive:
                os.killpg(self._process.pid, number)

    def wait(self, seconds: float) -> bool:
        """Return whether it has ended within this time."""
        try:
            self._process.wait(max(0.0, seconds))
        except subprocess.TimeoutExpired:
            return False
        return True


class Nodes(contextlib.AbstractContextManager["Nodes"]):
    """All processes of a demo; leaving the context ends them.

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
        self, name: str, *, parameters: Mapping[str, object] = {}, remap: Mapping[str, str] = {}
    ) -> NodeProcess:
        """Start a node; return at once."""
        process = NodeProcess(
            name, self._logs, parameters=parameters, remap=remap, environment=self._environment
        )
        self._running.append(process)
        return process

    def check(self) -> None:
        """Raise DemoError if one has ended."""
        for process in self._running:
            process.check()

    def peaks(self) -> dict[str, int]:
        """Return the most memory each has held, bytes."""
        self._peaks |= {process.name: process.measure() for process in self._running}
        return dict(self._peaks)

    def numbers(self) -> list[int]:
        """Return the ids of the processes that were not ended."""
        return [process.number for process in self._running]

    def tails(self) -> str:
        """Return the end of every log."""
        return "\n".join(f"{process.log}:\n{process.tail()}" for process in self._running)

    def end(self, *names: str) -> None:
        """Ask these to end, then kill them.

        Args:
            names: as in `peaks`; none for all.
        """
        self.peaks()
        ending = [process for process in self._running if not names or process.name in names]
        self._running = [process for process in self._running if process not in ending]
        _end(ending)

    def __exit__(self, *_: object) -> None:
        self.end()


def _end(processes: Sequence[NodeProcess]) -> None:
    for number, patience in ((signal.SIGINT, PATIENCE), (signal.SIGTERM, 1.0)):
        for process in processes:
            process.signal(number)
        deadline = time.monotonic() + patience
        for process in processes:
            process.wait(deadline - time.monotonic())
    for process in processes:
        process.signal(signal.SIGKILL)
        process.wait(PATIENCE)


def _end_with_parent() -> None:
    """Let the kernel end this process if the demo is killed (SIGKILL)."""
    assert _PRCTL is not None
    _PRCTL(_PR_SET_PDEATHSIG, signal.SIGTERM)


def _yaml(value: object) -> str:
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(map(_yaml, value)) + "]"
    return f'"{value}"' if isinstance(value, str) else str(value)


class OtherWork:
    """Processors that other programs keep busy, from the moment this is made.

    Args:
        ours: seconds of processor that our own processes took so far.
        stat: text of /proc/stat.
    """

    def __init__(
        self,
        ours: Callable[[], float],
        stat: Callable[[], str] = lambda: Path("/proc/stat").read_text(),
    ) -> None:
        self._ours, self._stat = ours, stat
        self._before = self._look()

    def processors(self) -> float:
        """Return how many processors others took; 0 if the system does not report it."""
        passed, busy, ours = (
            now - before for now, before in zip(self._look(), self._before, strict=True)
        )
        count = os.cpu_count() or 1
        return max(0.0, busy - ours) / passed * count if passed > 0.0 else 0.0

    def _look(self) -> tuple[float, float, float]:
        """Return processor seconds passed, those used, and those that we used."""
        try:
            columns = [int(text) for text in self._stat().split("\n", 1)[0].split()[1 : BUSY + 1]]
        except (OSError, ValueError):
            return 0.0, 0.0, 0.0
        ticks = os.sysconf("SC_CLK_TCK")
        idle = sum(columns[k] for k in IDLE)
        return sum(columns) / ticks, (sum(columns) - idle) / ticks, self._ours()


def processor_seconds(processes: Iterable[int]) -> float:
    """Return processor seconds that this process and those of these ids took."""
    mine = os.times()
    total = mine.user + mine.system
    for number in processes:
        try:
            # The name in parentheses may hold blanks; user and system time are the 12th and 13th
            # column behind it.
            columns = Path(f"/proc/{number}/stat").read_text().rpartition(")")[2].split()
        except OSError:
            continue
        total += (int(columns[11]) + int(columns[12])) / os.sysconf("SC_CLK_TCK")
    return total
