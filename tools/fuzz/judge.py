"""The judge: reads a file in a process that may die, and says how that ended and what it cost."""

import multiprocessing
import os
import resource
import time
import traceback
import warnings
from dataclasses import dataclass
from multiprocessing.connection import Connection
from multiprocessing.process import BaseProcess
from pathlib import Path

from fuzz.target import Target

SECONDS = 5.0
"""s of computing that any file may take; a clean one that takes long, three times as long."""
MEMORY = 500 << 20
"""Bytes that a file may take beyond what the clean one takes."""
ADDRESSES = 6 << 30
"""Bytes of address space at which the process is stopped, to save the machine."""
GOOD = ("read", "refused")


@dataclass(frozen=True)
class Verdict:
    """The end of one reading.

    Attributes:
        kind: "read" or "refused" with the package's own error, which are good; else "raised",
            "nameless" (an error that does not name its file), "slow", "large", "hung" or "died".
        seconds: of computing.  memory: bytes at most, beyond those before.
        text: the error.
    """

    kind: str
    seconds: float = 0.0
    memory: int = 0
    text: str = ""

    @property
    def good(self) -> bool:
        """Return whether the reader did what it must."""
        return self.kind in GOOD


class Judge:
    """Judges files of one target.

    Args:
        target: its reader.
        clean: its clean files, which set the limits.
    """

    def __init__(self, target: Target, clean: list[Path]) -> None:
        self._target = target
        self._process: BaseProcess | None = None
        self._pipe: Connection
        self.seconds, self.memory = SECONDS, MEMORY
        for path in clean:
            self.read(path)  # imports what it needs
            verdict = self.read(path)
            if verdict.kind != "read":
                raise SystemExit(f"{path} is clean and was {verdict.kind}: {verdict.text}")
            self.seconds = max(self.seconds, 3.0 * verdict.seconds)
            self.memory = max(self.memory, MEMORY + verdict.memory)

    def read(self, path: Path) -> Verdict:
        """Return how reading a file ends."""
        if self._process is None:
            # A thread of a library may hold a lock while this process forks: a new one is begun.
            context = multiprocessing.get_context("spawn")
            self._pipe, theirs = context.Pipe()
            self._process = context.Process(target=_serve, args=(self._target, theirs), daemon=True)
            self._process.start()
            theirs.close()
            self._pipe.recv()
        self._pipe.send(path)
        try:
            if not self._pipe.poll(8.0 * self.seconds):  # waits for a busy machine, too
                self.close()
                return Verdict("hung")
            verdict: Verdict = self._pipe.recv()
        except (EOFError, ConnectionError):
            code = self._process.exitcode
            self.close()
            return Verdict("died", text=f"exit code {code}")
        if verdict.good and verdict.seconds > self.seconds:
            return Verdict("slow", verdict.seconds, verdict.memory, verdict.text)
        if verdict.good and verdict.memory > self.memory:
            return Verdict("large", verdict.seconds, verdict.memory, verdict.text)
        return verdict

    def close(self) -> None:
        """End the process."""
        if self._process is not None:
            self._process.kill()
            self._process.join()
            self._pipe.close()
            self._process = None


def _serve(target: Target, pipe: Connection) -> None:
    warnings.simplefilter("ignore")
    os.dup2(os.open(os.devnull, os.O_WRONLY), 2)  # libraries in C say there what is damaged
    resource.setrlimit(resource.RLIMIT_AS, (ADDRESSES, ADDRESSES))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    pipe.send("ready")
    while True:
        path = pipe.recv()
        before = _memory("VmRSS")
        Path("/proc/self/clear_refs").write_text("5")  # the peak begins here
        begin = time.process_time()
        kind, text = judged(target, path)
        seconds = time.process_time() - begin
        # A text that cannot be sent could not be shown to a user either.
        try:
            text.encode()
        except UnicodeError as error:
            kind, text = "raised", f"the error's text cannot be shown: {error}"
        pipe.send(Verdict(kind, seconds, _memory("VmHWM") - before, text))


def judged(target: Target, path: Path) -> tuple[str, str]:
    """Return how reading a file ends in this process, and the error's text."""
    from lagrangian_ff.errors import UserError

    try:
        target.read(path)
    except UserError as error:
        named = path.name in str(error)
        return ("refused" if named else "nameless"), f"{type(error).__name__}: {error}"
    except BaseException:
        return "raised", traceback.format_exc()
    return "read", ""


def _memory(field: str) -> int:
    for line in Path("/proc/self/status").read_text().splitlines():
        if line.startswith(field):
            return int(line.split()[1]) << 10
    raise LookupError(field)
