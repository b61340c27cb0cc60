"""What `make` does on machines that differ: tried with a Python whose package index is imagined."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
INSTALL = "install --no-compile"

pytestmark = pytest.mark.skipif(shutil.which("make") is None, reason="make is not installed")

DEMO = "[arm,bags,ros,threads]"
TEST = "[arm,bags,docs,ros,test,threads]"


class Machine:
    """A clone, a Python and the programs that a machine has."""

    def __init__(self, folder: Path) -> None:
        self.clone = folder / "clone"
        (self.clone / "tools").mkdir(parents=True)
        for name in ("Makefile", "setup.py", "setup.cfg", "pyproject.toml"):
            shutil.copy(ROOT / name, self.clone)
        shutil.copy(ROOT / "tools" / "environment.py", self.clone / "tools")
        loops = Path("lagrangian_ff") / "loops"
        (self.clone / loops).mkdir(parents=True)
        shutil.copy(ROOT / loops / "build.py", self.clone / loops)
        self.calls = folder / "calls"
        self.python = folder / "python" / "python3.11"
        self.python.parent.mkdir()
        code = (Path(__file__).parent / "fake_python.py").read_text()
        self.python.write_text(f"#!{sys.executable}\n{code}")
        self.python.chmod(0o755)
        self.settings = {"wheel": True, "index": True, "fail": False, "version": [3, 11, 7]}
        self.path = folder / "programs"
        self.path.mkdir()
        for name in ("make", "sh", "awk", "echo", "test"):
            self.provide(name, shutil.which(name))

    def provide(self, name: str, program: str | None) -> None:
        """Put a program on the machine's path."""
        assert program, f"this test needs {name}"
        (self.path / name).symlink_to(program)

    def make(
        self, *arguments: str, python: str | None = None, **variables: str
    ) -> subprocess.CompletedProcess[str]:
        """Run make in the clone, with the environment variables given."""
        environments = [self.python.parent, self.clone / ".venv" / "bin"]
        for folder in (folder for folder in environments if folder.is_dir()):
            text = json.dumps(self.settings | {"calls": str(self.calls)})
            (folder / "settings.json").write_text(text)
        choice = [f"PYTHON={self.python if python is None else python}"]
        return subprocess.run(
            ["make", "-C", str(self.clone), "--no-print-directory", *arguments, *choice],
            capture_output=True,
            text=True,
            timeout=60,
            stdin=subprocess.DEVNULL,
            env={key: os.environ[key] for key in ("HOME", "LANG") if key in os.environ}
            | {"PATH": str(self.path), **variables},
        )

    def installations(self) -> list[str]:
        """Return the extras that pip was asked to install the package with, in order."""
        lines = self.calls.read_text().splitlines() if self.calls.exists() else []
        return [line[line.index("[") :] for line in lines if "--editable" in line]


@pytest.fixture
def machine(tmp_path: Path) -> Machine:
    return Machine(tmp_path)


def test_help_is_the_default_and_needs_nothing(machine: Machine) -> None:
    result = machine.make()
    assert result.returncode == 0, result.stderr
    assert not (machine.clone / ".venv").exists()
    for target in ("demo", "test", "lint", "format", "benchmark", "clean", "help"):
        assert f"\n  {target} " in result.stdout


def test_demo_installs_what_it_needs_and_runs(machine: Machine) -> None:
    result = machine.make("demo", "ARGS=--quick")
    assert result.returncode == 0, result.stderr
    assert result.stdout.splitlines()[-1] == "ran: lagrangian_ff demo --quick"
    assert machine.installations() == [DEMO]


def test_repeating_installs_nothing(machine: Machine) -> None:
    machine.make("demo")
    machine.calls.unlink()
    result = machine.make("demo")
    assert result.stdout == "PYTHONPATH=\nran: lagrangian_ff demo\n"
    assert not machine.calls.exists()


def test_a_sourced_ros_of_another_python_does_not_leak_in(machine: Machine) -> None:
    elsewhere = "/opt/ros/jazzy/lib/python3.12/site-packages"
    result = machine.make("demo", ROS_DISTRO="jazzy", PYTHONPATH=elsewhere)
    assert "PYTHONPATH=\n" in result.stdout
    result = machine.make("demo", PYTHONPATH="mine")
    assert "PYTHONPATH=mine\n" in result.stdout, "without ROS, the variable is the user's own"


def test_test_tools_come_on_top_and_stay(machine: Machine) -> None:
    machine.make("demo")
    machine.make("install")
    machine.make("demo")
    assert machine.installations() == [DEMO, TEST]


def test_changed_requirements_are_installed(machine: Machine) -> None:
    machine.make("install")
    with (machine.clone / "setup.py").open("a") as file:
        file.write("# another requirement\n")
    machine.make("demo")
    assert machine.installations() == [TEST] * 2


def test_a_failed_installation_is_told_and_not_taken_as_done(machine: Machine) -> None:
    machine.settings["fail"] = True
    result = machine.make("demo")
    assert result.returncode != 0
    assert "the disk is full" in result.stderr
    assert "Traceback" not in result.stderr
    assert "ran:" not in result.stdout
    machine.settings["fail"] = False
    result = machine.make("demo")
    assert "made again" in result.stdout
    assert "ran:" in result.stdout


@pytest.mark.parametrize("damage", ["python", "installed.json", "everything", "a file"])
def test_a_broken_environment_is_repaired(machine: Machine, damage: str) -> None:
    environment = machine.clone / ".venv"
    machine.make("demo")
    if damage == "python":
        (environment / "bin" / "python").unlink()
    elif damage == "installed.json":
        (environment / "installed.json").write_text('{"base": ')
    else:
        shutil.rmtree(environment)
        if damage == "a file":
            environment.touch()
        else:
            environment.mkdir()
    result = machine.make("demo")
    assert result.returncode == 0, result.stderr
    assert "ran:" in result.stdout
    assert machine.installations() == [DEMO] * 2


def test_a_moved_clone_gets_an_environment_of_its_own(machine: Machine) -> None:
    machine.make("demo")
    machine.clone = machine.clone.rename(machine.clone.with_name("moved"))
    result = machine.make("demo")
    assert "made again" in result.stdout
    assert "ran:" in result.stdout


def test_a_folder_that_is_no_environment_is_left_alone(machine: Machine) -> None:
    precious = machine.clone / "mine" / "precious"
    precious.parent.mkdir()
    precious.touch()
    result = machine.make("install", "VENV=mine")
    assert result.returncode != 0
    assert "mine" in result.stderr
    assert precious.exists()


def test_no_wheel_and_no_compiler_stops_before_anything_is_installed(machine: Machine) -> None:
    machine.settings |= {"wheel": False, "version": [3, 12, 3]}
    result = machine.make("demo")
    assert result.returncode != 0
    assert "PyBullet has no wheel for Python 3.12" in result.stderr
    assert "C++ compiler" in result.stderr
    assert "PYTHON=" in result.stderr
    assert "Traceback" not in result.stderr
    assert machine.installations() == []


def test_no_wheel_but_a_compiler_is_announced_and_done(machine: Machine) -> None:
    headers = subprocess.run(
        [sys.executable, "-c", "import sysconfig; print(sysconfig.get_paths()['include'])"],
        capture_output=True,
        text=True,
        check=True,
    )
    if not (Path(headers.stdout.strip()) / "Python.h").exists():
        pytest.skip("this machine's Python has no headers")
    machine.settings |= {"wheel": False, "version": list(sys.version_info[:3])}
    machine.provide("c++", shutil.which("true"))
    result = machine.make("demo")
    assert result.returncode == 0, result.stderr
    assert "must be compiled" in result.stdout
    assert result.stdout.index("must be compiled") < result.stdout.index("ran:")


def test_an_index_out_of_reach_is_told_apart_from_a_missing_wheel(machine: Machine) -> None:
    machine.settings |= {"wheel": False, "index": False}
    result = machine.make("demo")
    assert result.returncode != 0
    assert "index does not answer" in result.stderr
    assert "compile" not in result.stderr


@pytest.mark.parametrize("version", [[3, 9, 18], [3, 14, 0]])
def test_a_python_without_wheels_of_ros_is_refused(machine: Machine, version: list[int]) -> None:
    machine.settings["version"] = version
    result = machine.make("demo")
    assert result.returncode != 0
    assert "Python 3.10 to 3.13 is needed" in result.stderr
    assert ".".join(map(str, version)) in result.stderr
    assert not (machine.clone / ".venv").exists()


def test_no_python_at_all_says_what_to_install(machine: Machine) -> None:
    result = machine.make("demo", python="")
    assert result.returncode != 0
    assert "Install Python 3.11" in result.stderr
