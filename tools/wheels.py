"""Build the wheel with every Python of this machine, and use what it installs outside the sources.

make wheels, or python tools/wheels.py [PYTHON ...]

Each Python from 3.10 to 3.13 gets an empty environment with the wheel and what it requires, without
extras. In a folder elsewhere the command then identifies a model of a made recording, diagnoses it,
predicts with it and exports it to C. Needs the package index.
"""

import argparse
import os
import re
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
PYTHONS = tuple(f"3.{minor}" for minor in range(10, 14))
"""The Pythons that setup.py names."""
FILES = ("setup.py", "setup.cfg", "pyproject.toml", "package.xml", "MANIFEST.in")
FOLDERS = ("lagrangian_ff", "resource", "config", "launch")
WHICH = "import ensurepip, sys, venv; print('%d.%d' % sys.version_info[:2])"
RECORDING = """
import numpy as np
t = np.arange(0.0, 20.0, 0.01)
w = np.array([[1.1, 0.7], [2.3, 3.1]])
q = np.stack([np.sin(t[:, None] * w[:, n]) @ [0.7, 0.3] for n in (0, 1)], axis=1)
qd, qdd = np.gradient(q, t, axis=0), np.gradient(np.gradient(q, t, axis=0), t, axis=0)
tau = 5.0 * np.sin(q) + 2.0 * qdd + 0.8 * qd + 1.5 * np.tanh(qd / 0.02)
tau += np.random.default_rng(0).normal(0.0, 0.02, tau.shape)
np.savez("arm.npz", time=t, position=q, velocity=qd, effort=tau, joints=["joint_1", "joint_2"])
"""
COMMANDS = (
    ("help", ["--help"]),
    ("identify", ["identify", "arm.npz", "--model", "chain+fri", "--output", "model.npz"]),
    ("diagnose", ["diagnose", "model.npz", "arm.npz", "--steps", "1"]),
    ("predict", ["predict", "model.npz", "arm.npz", "--output", "torque.csv"]),
    ("export", ["export", "model.npz", "--to", "c", "--output", "arm_model"]),
)
MADE = ("model.npz", "torque.csv", "arm_model/arm_model.c")


@dataclass(frozen=True)
class Python:
    """A Python that runs and makes environments.

    Attributes:
        version: as `3.12`.  path: of the program.
    """

    version: str
    path: Path


class StepError(Exception):
    """A step did not work; the text names it and has the end of what it said."""


def pythons(versions: Sequence[str] = PYTHONS) -> list[Python]:
    """Return a Python of each version that this machine has, in that order."""
    return [found for version in versions if (found := python_of(version)) is not None]


def python_of(version: str) -> Python | None:
    """Return the first Python of a version that runs, on the path or in pyenv; None without one.

    A program of that name may be pyenv's, which runs only where its user has chosen that version.
    """
    for path in _candidates(version):
        try:
            done = subprocess.run([path, "-c", WHICH], capture_output=True, text=True, cwd="/")
        except OSError:
            continue
        if done.returncode == 0 and done.stdout.strip() == version:
            return Python(version, path)
    return None


def _candidates(version: str) -> Iterator[Path]:
    name = f"python{version}"
    for folder in os.get_exec_path():
        if (Path(folder) / name).is_file():
            yield Path(folder) / name
    if pyenv := shutil.which("pyenv"):
        listed = subprocess.run([pyenv, "versions", "--bare"], capture_output=True, text=True)
        for one in listed.stdout.split():
            if re.fullmatch(rf"{re.escape(version)}\.\d+", one):
                prefix = subprocess.run([pyenv, "prefix", one], capture_output=True, text=True)
                yield Path(prefix.stdout.strip()) / "bin" / name


def tried(python: Python, folder: Path) -> dict[str, float]:
    """Return s of each step with a Python, in a folder that is empty.

    Raises:
        StepError: a step did not work.
    """
    source, wheels, work = folder / "source", folder / "wheels", folder / "work"
    work.mkdir(parents=True)
    copy_sources(source)
    programs = folder / "venv" / "bin"
    pip: list[str | Path] = [programs / "python", "-m", "pip", "--quiet"]
    taken: dict[str, float] = {}

    def step(name: str, *command: str | Path) -> None:
        began = time.monotonic()
        done = subprocess.run(
            command, cwd=work, env=surroundings(), capture_output=True, text=True,
            stdin=subprocess.DEVNULL,
        )  # fmt: skip
        if done.returncode != 0:
            end = "\n".join((done.stdout + done.stderr).splitlines()[-25:])
            raise StepError(f"Python {python.version}: {name} failed:\n{end}")
        taken[name] = time.monotonic() - began

    step("environment", python.path, "-m", "venv", folder / "venv")
    step("wheel", *pip, "wheel", "--no-deps", "--wheel-dir", wheels, source)
    (wheel,) = wheels.glob("*.whl")
    shutil.rmtree(source)
    step("install", *pip, "install", "--no-compile", wheel)
    step("recording", programs / "python", "-c", RECORDING)
    for name, arguments in COMMANDS:
        step(name, programs / "lagrangian_ff", *arguments)
    if missing := [name for name in MADE if not (work / name).exists()]:
        raise StepError(f"Python {python.version}: {', '.join(missing)} was not written")
    return taken


def copy_sources(folder: Path) -> None:
    """Copy what a wheel is built from, and nothing that a build has left, to a folder."""
    folder.mkdir()
    for name in FILES:
        shutil.copy(ROOT / name, folder)
    for name in FOLDERS:
        ignored = shutil.ignore_patterns("__pycache__", "*.pyc", "*.so")
        shutil.copytree(ROOT / name, folder / name, ignore=ignored)


def surroundings() -> dict[str, str]:
    """Return the variables of a shell that knows neither the sources nor another environment."""
    hidden = ("PYTHON", "VIRTUAL_ENV", "PYENV_VERSION", "PIP_USER")
    return {key: value for key, value in os.environ.items() if not key.startswith(hidden)}


def main() -> int:
    """Try every Python there is and return the exit code."""
    parser = argparse.ArgumentParser(description="Build and use the wheel with every Python.")
    parser.add_argument("versions", nargs="*", metavar="PYTHON", help="as 3.12 (default: all)")
    versions = parser.parse_args().versions or PYTHONS
    found, wrong = {one.version: one for one in pythons(versions)}, 0
    for version in versions:
        if version not in found:
            print(f"{version}: there is none on the path or in pyenv", flush=True)
            continue
        with tempfile.TemporaryDirectory() as folder:
            try:
                taken = tried(found[version], Path(folder) / "tried")
            except StepError as error:
                print(error, flush=True)
                wrong += 1
                continue
        steps = ", ".join(f"{name} {seconds:.1f}" for name, seconds in taken.items())
        print(f"{version}: works, {sum(taken.values()):.0f} s ({steps})", flush=True)
    return 1 if wrong or not found else 0


if __name__ == "__main__":
    sys.exit(main())
