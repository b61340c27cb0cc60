"""The executables as a shell starts them: help, arguments that are none, and an early end."""

import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

pytest.importorskip("rclpy")

from lagrangian_ff.nodes import executables

NAMES = ("arm", "feedforward", "identify", "monitor", "watchdog")


def command(name: str) -> Path:
    path = Path(sys.prefix) / "bin" / name
    if not path.exists():
        pytest.skip(f"{name} is not installed beside {sys.executable}")
    return path


def start(name: str, *arguments: str) -> "subprocess.CompletedProcess[str]":
    return subprocess.run([command(name), *arguments], capture_output=True, text=True, timeout=60.0)


def test_each_node_has_an_executable() -> None:
    assert all(callable(getattr(executables, name)) for name in NAMES)


@pytest.mark.parametrize("name", NAMES)
def test_help_tells_of_the_topics_and_parameters(name: str) -> None:
    if name == "arm":
        pytest.importorskip("pybullet")
    done = start(name, "--help")
    assert done.returncode == 0
    assert f"usage: ros2 run lagrangian_ff {name}" in done.stdout
    assert "joint_states" in done.stdout or "commands" in done.stdout
    assert f"config/{name}.yaml" in done.stdout
    assert not done.stderr


def test_arguments_that_are_none_of_ros_are_refused(ros_environment: dict[str, str]) -> None:
    done = start("monitor", "--modle", "a.npz", "--ros-args", "-r", "__ns:=/left")
    assert done.returncode == 2
    assert "--modle a.npz is no argument of monitor" in done.stderr


def test_a_model_that_there_is_not_is_refused_at_the_start(ros_environment: dict[str, str]) -> None:
    done = start("identify", "--ros-args", "-p", "model:=nonsense+fri")
    assert done.returncode == 2
    assert "'nonsense' is neither a kernel" in done.stderr
    assert "Traceback" not in done.stderr


@pytest.mark.parametrize("after", [0.05, 0.15, 0.3])
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_node_that_still_loads_ends_quietly(
    ros_environment: dict[str, str], after: float, number: signal.Signals
) -> None:
    # The interpreter itself has no handler in its first moments.
    code = (
        "import sys; from lagrangian_ff.nodes import executables; print('begins', flush=True); "
        "sys.argv = ['identify']; sys.exit(executables.identify())"
    )
    process = subprocess.Popen(
        [sys.executable, "-c", code], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )
    assert process.stdout is not None
    assert process.stdout.readline().strip() == "begins"
    time.sleep(after)
    process.send_signal(number)
    _, said = process.communicate(timeout=60.0)
    assert process.returncode == 0
    assert "Traceback" not in said
