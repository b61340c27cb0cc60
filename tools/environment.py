"""Make the clone's own Python environment, or find that it is already complete.

Run by the Makefile with the Python to build on; needs nothing but that Python::

    python3.11 tools/environment.py .venv --extras ros,arm,bags,threads,test

What was installed is written to a stamp inside the environment, last of all. A run that finds the
stamp in order returns at once; one that finds the traces of an interrupted installation starts the
environment again, since pip takes a half-copied package for an installed one.
"""

from __future__ import annotations

import argparse
import fcntl
import hashlib
import json
import os
import platform
import re
import shutil
import subprocess
import sys
import sysconfig
import threading
import time
from pathlib import Path
from runpy import run_path

ROOT = Path(__file__).resolve().parent.parent
OLDEST, NEWEST = (3, 10), (3, 13)  # the Pythons that have wheels of rclpy
VERSION = f"{sys.version_info[0]}.{sys.version_info[1]}"
BUILD = ["pip >=23.1", "setuptools ==68.1.2", "wheel"]  # this setuptools is what colcon needs
IMPORTS = {
    "": "scipy.linalg, matplotlib.figure",
    "ros": "rclpy, sensor_msgs.msg",
    "arm": "pybullet",
    "bags": "mcap.writer",
}
NAMES = {"ros": "ROS 2", "arm": "PyBullet", "test": "the test tools"}
# Files whose change means that the environment has to be looked at again.
INPUTS = ["setup.py", "setup.cfg", "pyproject.toml", "tools/environment.py"]
LOOPS = ROOT / "lagrangian_ff" / "loops"


class SetupError(Exception):
    """Set-up cannot go on; the text says why and what to do."""


def say(text: str) -> None:
    """Print a message at once, also where the output is a pipe."""
    print(text, flush=True)


def quietly(command: list[str | Path]) -> subprocess.CompletedProcess[str]:
    """Run a command that asks nothing, and return what it said."""
    return subprocess.run(command, capture_output=True, text=True, stdin=subprocess.DEVNULL)


def surroundings() -> dict[str, str]:
    """Return the variables that what runs here is to see."""
    # A user's preference for installing elsewhere must not reach this environment.
    seen = {**os.environ, "PIP_USER": "0", "PIP_DISABLE_PIP_VERSION_CHECK": "1"}
    # Containers often forbid bytecode: every command would compile NumPy and SciPy, for seconds.
    seen.pop("PYTHONDONTWRITEBYTECODE", None)
    return seen


def check_python() -> None:
    """Raise SetupError where this Python cannot carry the environment."""
    found = f"{sys.executable} is Python {platform.python_version()}"
    if not OLDEST <= sys.version_info[:2] <= NEWEST:
        raise SetupError(
            f"Python {OLDEST[0]}.{OLDEST[1]} to {NEWEST[0]}.{NEWEST[1]} is needed (3.11 is best: it"
            f" has wheels of everything), but {found}.\n"
            "Install Python 3.11, or name another one: make demo PYTHON=/path/to/python3.11"
        )
    try:
        import ensurepip  # noqa: F401
        import venv  # noqa: F401
    except ImportError as error:
        raise SetupError(
            f"{found}, which cannot make virtual environments ({error}).\n"
            f"On Debian and Ubuntu: apt install python{VERSION}-venv"
        ) from None


def check_simulator(python: Path) -> None:
    """Say so where pip of `python` has to compile PyBullet.

    Raises
    ------
    SetupError
        where that cannot work for want of a compiler or headers, or there is no package index.
    """
    found = re.search(r'"(pybullet [^"]*)"', (ROOT / "setup.py").read_text())
    requirement = found.group(1) if found else "pybullet"
    pip: list[str | Path] = [python, "-m", "pip"]
    wheel = ["install", "--dry-run", "--no-deps", "--only-binary", ":all:", requirement]
    if quietly([*pip, *wheel]).returncode == 0:
        return
    known = quietly([*pip, "index", "versions", "pybullet"])
    if known.returncode != 0:
        end = "  ".join(known.stderr.strip().splitlines(keepends=True)[-3:])
        raise SetupError(f"The Python package index does not answer; pip says:\n  {end}")
    what = (
        f"PyBullet has no wheel for Python {VERSION} on {platform.system()} {platform.machine()}"
        " (Linux x86_64 has them up to Python 3.11), so it must be compiled."
    )
    better = "Python 3.11 spares you this: make demo PYTHON=/path/to/python3.11"
    missing = []
    if not any(shutil.which(name) for name in (os.environ.get("CXX", "c++"), "g++", "clang++")):
        missing.append("a C++ compiler (Debian, Ubuntu: apt install g++)")
    if not (Path(sysconfig.get_paths()["include"]) / "Python.h").exists():
        missing.append(f"Python's headers (Debian, Ubuntu: apt install python{VERSION}-dev)")
    if missing:
        raise SetupError(f"{what} That needs {' and '.join(missing)}.\n{better}")
    say(f"{what} This takes about ten minutes, once.\n{better}")


class Progress:
    """One line with what pip does and for how long; on a pipe, a line for each stage."""

    stages = (
        ("Collecting", "downloading"),
        ("Building wheel for", "building"),
        ("Installing collected", "unpacking"),
    )

    def __init__(self, what: str) -> None:
        self.stage = what
        self.package = ""
        self.start = time.monotonic()
        self.done = threading.Event()
        self.thread = threading.Thread(target=self.tick, daemon=True)
        self.terminal = sys.stdout.isatty()

    def __enter__(self) -> Progress:
        if self.terminal:
            self.thread.start()
        else:
            say(f"  {self.stage}")
        return self

    def __exit__(self, *error: object) -> None:
        self.done.set()
        if self.terminal:
            self.thread.join()
            print("\r\033[K", end="", flush=True)

    def follow(self, line: str) -> None:
        """Take a line of pip's output."""
        for beginning, stage in self.stages:
            if line.strip().startswith(beginning):
                rest = line.strip()[len(beginning) :].split()
                self.package = "" if stage == "unpacking" else rest[0]
                if stage != self.stage and not self.terminal:
                    say(f"  {stage}" + (f" {self.package}" if stage == "building" else ""))
                self.stage = stage

    def tick(self) -> None:
        """Rewrite the line twice a second until done."""
        while not self.done.wait(0.5):
            seconds = int(time.monotonic() - self.start)
            text = f"{self.stage} {self.package}"[:60]
            print(f"\r\033[K  {seconds:3d} s  {text}", end="", flush=True)


class Environment:
    """The virtual environment in a directory, and the stamp that says what is in it."""

    def __init__(self, directory: Path, constraints: Path | None) -> None:
        self.directory = directory
        self.constraints = constraints
        self.python = directory / "bin" / "python"
        self.stamp = directory / "installed.json"
        self.unfinished = directory / "installing"
        self.log = directory / "install.log"

    def base(self) -> str:
        """Return what the environment rests on: its own place, the clone's, and the Python."""
        return f"{self.directory} {ROOT} {sys.base_prefix} {VERSION}"

    def fingerprint(self) -> str:
        """Return a digest of everything that decides what gets installed."""
        digest = hashlib.sha256()
        loops = (path for path in sorted(LOOPS.glob("*")) if path.suffix in (".c", ".h", ".py"))
        for path in [*(ROOT / name for name in INPUTS), *loops, self.constraints]:
            digest.update(path.read_bytes() if path else b"")
        return digest.hexdigest()

    def installed(self) -> dict[str, str]:
        """Return the stamp, empty where there is none that can be read."""
        try:
            return dict(json.loads(self.stamp.read_text()))
        except (OSError, ValueError):
            return {}

    def sound(self) -> bool:
        """Tell whether the environment starts and was not left half made."""
        if self.unfinished.exists() or self.installed().get("base") != self.base():
            return False
        try:
            return quietly([self.python, "-c", ""]).returncode == 0
        except OSError:
            return False

    def create(self) -> None:
        """Make the empty environment in place of whatever is there."""
        if self.directory.exists():
            ours = self.directory.parent == ROOT and self.directory.name.startswith(".venv")
            if not ours and not (self.directory / "pyvenv.cfg").exists():
                raise SetupError(f"{self.directory} is in the way: no virtual environment.")
            say(f"{self.directory.name} is incomplete or was made for another place: made again")
            if self.directory.is_dir() and not self.directory.is_symlink():
                shutil.rmtree(self.directory)
            else:
                self.directory.unlink()
        self.directory.mkdir(parents=True)
        self.unfinished.touch()
        self.run("making the environment", [sys.executable, "-m", "venv", self.directory])
        compiler = run_path(str(LOOPS / "build.py"))["requirements"]()
        self.pip("preparing", *BUILD, *compiler)

    def install(self, extras: list[str]) -> None:
        """Install the package, editable, with its requirements and those of the extras."""
        self.unfinished.touch()
        self.stamp.unlink(missing_ok=True)
        if "arm" in extras:
            check_simulator(self.python)
        arguments = ["--constraint", str(self.constraints)] if self.constraints else []
        # Bytecode is written at first import instead: most of what is installed is never imported.
        arguments += ["--no-compile", "--no-build-isolation", "--editable"]
        self.pip("installing", *arguments, f"{ROOT}[{','.join(extras)}]")
        modules = [modules for extra, modules in IMPORTS.items() if extra in ("", *extras)]
        self.run("checking", [self.python, "-c", f"import {', '.join(modules)}"])
        text = {"base": self.base(), "fingerprint": self.fingerprint(), "extras": ",".join(extras)}
        partial = self.stamp.with_suffix(".part")
        partial.write_text(json.dumps(text))
        partial.replace(self.stamp)
        self.unfinished.unlink()

    def pip(self, what: str, *arguments: str) -> None:
        """Run `pip install` in the environment; see `run`."""
        self.run(what, [self.python, "-m", "pip", "install", *arguments])

    def run(self, what: str, command: list[str | Path]) -> None:
        """Run a command with its output in the log and a line of progress on the terminal.

        Raises
        ------
        SetupError
            with the end of the output, where the command fails.
        """
        lines = [f"$ {' '.join(str(word) for word in command)}\n"]
        with Progress(what) as progress, self.log.open("a", encoding="utf-8") as log:
            log.write(lines[0])
            process = subprocess.Popen(
                command,
                stdin=subprocess.DEVNULL,
                stdout=subprocess.PIPE,
                stderr=subprocess.STDOUT,
                text=True,
                env=surroundings(),
            )
            for line in process.stdout or ():
                lines.append(line)
                log.write(line)
                progress.follow(line)
            process.wait()
        if process.returncode != 0:
            telling = [line for line in lines if not line.startswith("WARNING")]
            end = "  ".join(telling[-15:]).rstrip()
            raise SetupError(f"{what} failed; the end of {self.log}:\n  {end}")


def main() -> int:
    """Bring the environment in order and return the exit code."""
    parser = argparse.ArgumentParser(description="Make the clone's own Python environment.")
    parser.add_argument("directory", type=Path, help="where it lies, e.g. .venv")
    parser.add_argument("--extras", default="ros", help="extras of setup.py, with commas")
    parser.add_argument("--constraints", type=Path, help="a file of exact versions to install")
    options = parser.parse_args()
    environment = Environment(ROOT / options.directory, options.constraints)
    wanted = set(options.extras.split(","))
    # Two makes at a time: the second waits, and then finds the work done.
    with Path(__file__).open() as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        try:
            check_python()
            sound = environment.sound()
            stamp = environment.installed()
            have = set(stamp["extras"].split(",")) if sound else set()
            if sound and stamp["fingerprint"] == environment.fingerprint() and wanted <= have:
                return 0
            start = time.monotonic()
            parts = [name for extra, name in NAMES.items() if extra in wanted]
            listed = (
                " and ".join(filter(None, [", ".join(parts[:-1]), *parts[-1:]])) or "the package"
            )
            say(f"Installing {listed} into {options.directory} (once, about 1 GB)")
            if not sound:
                environment.create()
            environment.install(sorted(wanted | have))
            say(f"Installed in {time.monotonic() - start:.0f} s")
        except (SetupError, OSError) as error:
            print(f"\n{error}", file=sys.stderr)
            return 2
        except KeyboardInterrupt:
            print("\nInterrupted; the next run starts the environment again.", file=sys.stderr)
            return 130
    return 0


if __name__ == "__main__":
    sys.exit(main())
