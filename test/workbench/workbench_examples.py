"""A running workbench, and recordings for it: two joints, one with drag that no usual model has."""

import re
import signal
import subprocess
import sys
import time
import urllib.error
import urllib.request
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np

from lagrangian_ff.recording import Recording, write_npz

JOINTS = ("a", "b")
PATIENCE = 60.0  # s
RUN = "import sys; from lagrangian_ff.cli.main import main; sys.exit(main(sys.argv[1:]))"


def moved(
    path: Path,
    seed: int,
    drag: float = 0.9,
    seconds: float = 24.0,
    sign: tuple[float, float] = (1.0, 1.0),
    rough: float = 0.0,
    late: float = 0.0,
) -> Path:
    """Write a recording of a motion with quadratic drag on joint b.

    Args:
        sign: of the effort that is written.
        rough: N·m of friction on joint b that is a wave over its position, as no known effect is.
        late: s by which the effort comes later than the position.
    """
    random = np.random.default_rng(seed)
    time_, phase = np.arange(0.0, seconds, 0.02), random.uniform(0.0, 6.0, (2, 2))
    q, qd, qdd = (np.zeros((len(time_), 2)) for _ in range(3))
    for k, (amplitude, speed) in enumerate(((0.5, (1.1, 1.7)), (0.4, (3.1, 3.7)))):
        w = np.array(speed)
        angle = time_[:, None] * w + phase[k]
        q += amplitude * np.sin(angle)
        qd += amplitude * w * np.cos(angle)
        qdd -= amplitude * w**2 * np.sin(angle)
    tau = 8.0 * np.cos(q) + 1.5 * qdd + 0.4 * qd + np.tanh(qd / 0.02)
    tau[:, 1] += drag * qd[:, 1] * np.abs(qd[:, 1])
    tau[:, 1] += rough * np.tanh(qd[:, 1] / 0.02) * np.sin(5.3 * q[:, 1])
    tau += 0.05 * random.standard_normal(tau.shape)
    tau = np.stack([np.interp(time_ - late, time_, one) for one in tau.T], axis=1)
    return write_npz(path, Recording(JOINTS, time_, q, qd, tau * sign, start=1.7e9))


class Served:
    """A workbench in its process."""

    def __init__(self, session: Path, *arguments: object) -> None:
        self.session = session
        self.log = session.with_suffix(".log")
        command = [sys.executable, "-u", "-c", RUN, "workbench"]
        command += [*map(str, arguments), "--session", str(session), "--port", "0", "--no-browser"]
        with self.log.open("a") as output:
            began = output.tell()
            self._process = subprocess.Popen(command, stdout=output, stderr=subprocess.STDOUT)
        end = time.monotonic() + PATIENCE
        while not (found := re.search(r"workbench: (http\S+)", self.log.read_text()[began:])):
            assert self._process.poll() is None, self.log.read_text()
            assert time.monotonic() < end, "the workbench does not start"
            time.sleep(0.05)
        self.address = found[1]

    @property
    def pid(self) -> int:
        return self._process.pid

    def stop(self, number: int = signal.SIGTERM) -> int:
        """End it, and return its exit code."""
        self._process.send_signal(number)
        return self._process.wait(PATIENCE)

    def asked(self, path: str, data: bytes | None = None, **headers: str) -> tuple[int, bytes]:
        """Return what it answers to a request: status and body."""
        base = self.address.partition("?")[0]
        request = urllib.request.Request(base + path, data=data)
        for name, value in headers.items():
            request.add_header(name, value)
        try:
            with urllib.request.urlopen(request, timeout=20.0) as answer:
                return answer.status, answer.read()
        except urllib.error.HTTPError as error:
            return error.code, error.read()

    def end(self) -> None:
        """End it if it still runs."""
        if self._process.poll() is None:
            self._process.kill()
            self._process.wait(PATIENCE)


def serving() -> Iterator[Callable[..., Served]]:
    """Yield what starts workbenches, and end those that still run."""
    made: list[Served] = []

    def start(*given: Any) -> Served:
        made.append(Served(*given))
        return made[-1]

    try:
        yield start
    finally:
        for one in made:
            one.end()
