"""A small arm with known torques, and how the tests of this folder run the command line."""

import io
import json
import os
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Sequence
from contextlib import redirect_stderr, redirect_stdout
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from lagrangian_ff.cli.main import main
from lagrangian_ff.recording import Recording, write_csv

Floats = NDArray[np.float64]
JOINTS = ("shoulder", "elbow")
VISCOUS, COULOMB = (0.8, 0.3), (1.5, 0.6)


def torque(q: Floats, qd: Floats, qdd: Floats, friction: bool = True) -> Floats:
    """N·m of two links of 1 m with 1 kg at their ends, in the vertical plane, and friction."""
    c2, s2 = np.cos(q[:, 1]), np.sin(q[:, 1])
    g1, g2 = 9.81 * np.cos(q[:, 0]), 9.81 * np.cos(q[:, 0] + q[:, 1])
    coupling = s2 * (2.0 * qd[:, 0] * qd[:, 1] + qd[:, 1] ** 2)
    first = (3.0 + 2.0 * c2) * qdd[:, 0] + (1.0 + c2) * qdd[:, 1] - coupling + 2.0 * g1 + g2
    second = (1.0 + c2) * qdd[:, 0] + qdd[:, 1] + s2 * qd[:, 0] ** 2 + g2
    rigid = np.stack([first, second], axis=1)
    if not friction:
        return rigid
    return rigid + np.array(VISCOUS) * qd + np.array(COULOMB) * np.tanh(qd / 0.02)


def motion(
    seconds: float, rate: float, reach: float = 1.0
) -> tuple[Floats, Floats, Floats, Floats]:
    """Time (M,) and q, qd, qdd (M, 2) of a motion that visits its range again and again."""
    time = np.round(np.arange(round(seconds * rate)) / rate, 9)
    omega = np.array([[1.1, 2.3, 3.7], [1.7, 2.9, 4.3]])
    size = reach * np.array([[0.6, 0.3, 0.15], [0.7, 0.3, 0.1]])
    phase = omega * time[:, None, None] + np.array([[0.0, 1.0, 2.0], [0.5, 1.5, 2.5]])
    return (
        time,
        (size * np.sin(phase)).sum(axis=2),
        (size * omega * np.cos(phase)).sum(axis=2),
        -(size * omega**2 * np.sin(phase)).sum(axis=2),
    )


def arm(
    seconds: float = 24.0,
    rate: float = 100.0,
    joints: tuple[str, ...] = JOINTS,
    reach: float = 1.0,
    friction: bool = True,
) -> Recording:
    """The small arm as its driver would report it."""
    time, q, qd, qdd = motion(seconds, rate, reach)
    return Recording(joints, time, q, qd, torque(q, qd, qdd, friction), 1_700_000_000.0)


def csv(path: Path, recording: Recording) -> Path:
    """The recording as a CSV file."""
    return write_csv(path, recording)


@dataclass(frozen=True)
class Outcome:
    """What a run of the command line left: exit code, standard output and error."""

    code: int
    out: str
    err: str

    @property
    def text(self) -> str:
        """Everything that was printed, on one line, so that wrapping does not matter."""
        return " ".join((self.out + " " + self.err).split())


def lagrangian_ff(*arguments: str | Path) -> Outcome:
    """Run a command in this process."""
    out, err = io.StringIO(), io.StringIO()
    with redirect_stdout(out), redirect_stderr(err):
        try:
            code = main([str(argument) for argument in arguments])
        except SystemExit as end:
            code = int(end.code or 0)
    return Outcome(code, out.getvalue(), err.getvalue())


def command() -> list[str]:
    """The installed command, or where it is not installed, the module."""
    beside = Path(sys.executable).with_name("lagrangian_ff")
    colcon = Path(sys.prefix) / "lib" / "lagrangian_ff" / "lagrangian_ff"
    for script in (beside, colcon):
        if os.access(script, os.X_OK) and script.is_file():
            return [str(script)]
    found = shutil.which("lagrangian_ff")
    return [found] if found else [sys.executable, "-m", "lagrangian_ff.cli"]


def process(*arguments: str | Path) -> Outcome:
    """Run a command through its entry point, in a process of its own."""
    done = subprocess.run(
        [*command(), *map(str, arguments)], capture_output=True, text=True, timeout=120, check=False
    )
    return Outcome(done.returncode, done.stdout, done.stderr)


def interrupted(when: str, *arguments: str | Path) -> Outcome:
    """Run a command through its entry point; press Ctrl-C once it has printed these words."""
    running = subprocess.Popen(
        [*command(), *map(str, arguments)],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env={**os.environ, "PYTHONUNBUFFERED": "1"},
        # What a test runner in the background ignores, its children would.
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler) and None,
    )
    try:
        assert running.stdout is not None
        out = ""
        while when not in out and (line := running.stdout.readline()):
            out += line
        time.sleep(0.5)
        running.send_signal(signal.SIGINT)
        rest, errors = running.communicate(timeout=60)
    finally:
        running.kill()
    return Outcome(running.returncode, out + rest, errors)


def assert_refused(outcome: Outcome, *words: str) -> None:
    """Exit code 2, one error that names these, and no traceback."""
    assert outcome.code == 2, outcome
    assert "Traceback" not in outcome.text
    error = next(line for line in outcome.err.splitlines() if line.startswith("error: "))
    missing = [word for word in words if word not in error]
    assert not missing, f"{missing} not in: {error}"


QUICK: Sequence[str] = ("--samples", "60", "--block", "1")
"""Options that make an identification take a second."""


def small_model(path: Path, *arguments: str, joints: tuple[str, ...] = JOINTS) -> Path:
    """A model of the small arm, learned in a second; further options of identify may follow."""
    source = csv(path.with_suffix(".csv"), arm(joints=joints))
    outcome = lagrangian_ff(
        "identify", source, *QUICK, "--train", "1.0", "--output", path, *arguments
    )  # fmt: skip
    assert outcome.code == 0, outcome
    return path


def tampered(model: Path, path: Path, **header: object) -> Path:
    """The model with some entries of its header changed."""
    with np.load(model) as file:
        arrays = {name: file[name] for name in file.files}
    entries = {**json.loads(bytes(arrays["header"])), **header}
    arrays["header"] = np.frombuffer(json.dumps(entries).encode(), dtype=np.uint8)
    np.savez(path, **arrays)
    return path
