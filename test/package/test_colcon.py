"""The package builds with colcon, and what was installed is found and run as `ros2 run` would."""

from __future__ import annotations

import os
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path
from xml.etree import ElementTree

import pytest

ROOT = Path(__file__).resolve().parents[2]
NODES = ("identify", "feedforward", *(["arm"] if find_spec("pybullet") else []))
"""Those that start without a model."""
EXECUTABLES = {"lagrangian_ff", "identify", "feedforward", "monitor", "watchdog", "arm"}
COLCON = Path(sys.executable).parent / "colcon"

pytestmark = [
    pytest.mark.skipif(not COLCON.exists(), reason="colcon is not installed beside this Python")
]


@dataclass(frozen=True)
class Workspace:
    """A colcon workspace, built, and the environment of a shell in which it is sourced."""

    source: Path
    install: Path
    environment: dict[str, str]

    @property
    def prefix(self) -> Path:
        return self.install / "lagrangian_ff"

    def python(self, code: str) -> str:
        """Return what a line of Python prints in the sourced environment."""
        command = [sys.executable, "-c", code]
        result = subprocess.run(
            command, env=self.environment, cwd="/", capture_output=True, text=True, check=True
        )
        return result.stdout.strip()


def build(folder: Path, *options: str) -> Workspace:
    """Build a copy of the package, and source it."""
    source = folder / "src" / "lagrangian_ff"
    source.mkdir(parents=True)
    for name in ("setup.py", "setup.cfg", "pyproject.toml", "package.xml"):
        shutil.copy(ROOT / name, source)
    for name in ("lagrangian_ff", "resource", "config", "launch"):
        # What is linked to is compiled already, and stays so.
        compiled = [] if "--symlink-install" in options else ["*.so"]
        ignore = shutil.ignore_patterns("__pycache__", "*.pyc", *compiled)
        shutil.copytree(ROOT / name, source / name, ignore=ignore)
    bases = [f"--{name}-base={folder / name}" for name in ("build", "install")]
    command = [str(COLCON), f"--log-base={folder / 'log'}", "build", f"--base-paths={source}"]
    result = subprocess.run(
        [*command, *bases, *options], cwd=folder, capture_output=True, text=True, timeout=120
    )
    assert result.returncode == 0, result.stdout + result.stderr
    assert "Finished <<< lagrangian_ff" in result.stdout
    shell = ["sh", "-c", '. "$0" && env -0', str(folder / "install" / "setup.sh")]
    sourced = subprocess.run(shell, cwd=folder, capture_output=True, text=True, check=True)
    pairs = (entry.partition("=") for entry in sourced.stdout.split("\0") if entry)
    return Workspace(source, folder / "install", {name: value for name, _, value in pairs})


@pytest.fixture(scope="module")
def workspace(
    tmp_path_factory: pytest.TempPathFactory, ros_environment: dict[str, str]
) -> Workspace:
    """Return the workspace after `colcon build`, in the test session's own ROS domain."""
    built = build(tmp_path_factory.mktemp("workspace"))
    assert built.environment["ROS_DOMAIN_ID"] == ros_environment["ROS_DOMAIN_ID"]
    return built


@pytest.fixture
def index(workspace: Workspace, monkeypatch: pytest.MonkeyPatch) -> None:
    """Point the ament index of this process at the workspace and the environment's root."""
    path = workspace.environment["AMENT_PREFIX_PATH"]
    assert path.split(os.pathsep)[0] == str(workspace.prefix)
    monkeypatch.setenv("AMENT_PREFIX_PATH", path)


def test_the_ament_index_finds_the_package(index: None, workspace: Workspace) -> None:
    ament = pytest.importorskip("ament_index_python")
    assert ament.get_package_prefix("lagrangian_ff") == str(workspace.prefix)
    assert "rclpy" in ament.get_packages_with_prefixes()
    share = Path(ament.get_package_share_directory("lagrangian_ff"))
    assert (share / "package.xml").read_text() == (ROOT / "package.xml").read_text()
    kinds = {"config": "*.yaml", "config/arms": "*.yaml", "launch": "*.launch.py"}
    for folder, pattern in kinds.items():
        names = {file.name for file in (ROOT / folder).glob(pattern)}
        assert names, f"the package has nothing in {folder}/"
        there = {file.name for file in (share / folder).iterdir() if file.is_file()}
        assert there == names


def test_executables_lie_where_ros2_run_looks(index: None, workspace: Workspace) -> None:
    ament = pytest.importorskip("ament_index_python")
    folder = Path(ament.get_package_prefix("lagrangian_ff")) / "lib" / "lagrangian_ff"
    assert {file.name for file in folder.iterdir()} == EXECUTABLES
    for file in folder.iterdir():
        assert os.access(file, os.X_OK)
        interpreter = file.read_text().splitlines()[0].removeprefix("#!").strip()
        assert Path(interpreter).parent == Path(sys.executable).parent


def test_everything_of_the_package_is_installed(workspace: Workspace) -> None:
    place = Path(workspace.python("import lagrangian_ff; print(lagrangian_ff.__file__)")).parent
    assert place.is_relative_to(workspace.prefix)
    package = workspace.source / "lagrangian_ff"
    kept = (file for file in package.rglob("*") if file.is_file())
    files = {file.relative_to(package) for file in kept if file.suffix not in (".c", ".h")}
    assert {file for file in files if not (place / file).exists()} == set()
    assert workspace.python("from lagrangian_ff.loops import loop; print(loop('exponentials'))")


def test_entry_points_load_from_the_workspace(workspace: Workspace) -> None:
    place = workspace.python(
        "from importlib.metadata import entry_points, distribution\n"
        "import inspect\n"
        "for point in distribution('lagrangian_ff').entry_points:\n"
        "    print(point.name, inspect.getfile(point.load()))"
    )
    files = dict(line.split(" ", 1) for line in place.splitlines())
    assert set(files) == EXECUTABLES
    assert all(Path(file).is_relative_to(workspace.prefix) for file in files.values())


def test_the_command_answers_from_the_workspace(workspace: Workspace) -> None:
    command = [str(workspace.prefix / "lib" / "lagrangian_ff" / "lagrangian_ff"), "--help"]
    result = subprocess.run(
        command, env=workspace.environment, capture_output=True, text=True, timeout=60
    )
    assert result.returncode == 0, result.stderr
    assert "identify" in result.stdout


@pytest.fixture
def graph(ros_environment: dict[str, str]) -> Iterator[object]:
    """Yield a node of the test's own that sees which others there are."""
    rclpy = pytest.importorskip("rclpy")
    context = rclpy.Context()
    rclpy.init(context=context)
    node = rclpy.create_node("watcher", context=context)
    yield node
    node.destroy_node()
    rclpy.try_shutdown(context=context)


@contextmanager
def started(workspace: Workspace, name: str, folder: Path) -> Iterator[subprocess.Popen[bytes]]:
    """Start a node of the workspace, which writes to a file of its name."""
    with (folder / name).open("w") as file:
        process = subprocess.Popen(
            [workspace.prefix / "lib" / "lagrangian_ff" / name],
            env=workspace.environment,
            cwd=folder,
            stdin=subprocess.DEVNULL,
            stdout=file,
            stderr=subprocess.STDOUT,
            start_new_session=True,
        )
    try:
        yield process
    finally:
        if process.poll() is None:
            os.killpg(process.pid, signal.SIGKILL)
            process.wait()


def test_the_nodes_start_from_the_workspace_and_stop_when_told(
    workspace: Workspace, graph: object, tmp_path: Path
) -> None:
    with ExitStack() as stack:
        nodes = {name: stack.enter_context(started(workspace, name, tmp_path)) for name in NODES}
        end = time.monotonic() + 60
        while not set(NODES) <= set(graph.get_node_names()):  # type: ignore[attr-defined]
            for name, process in nodes.items():
                assert process.poll() is None, (tmp_path / name).read_text()
            assert time.monotonic() < end, graph.get_node_names()  # type: ignore[attr-defined]
            time.sleep(0.1)
        for process in nodes.values():
            os.killpg(process.pid, signal.SIGINT)
        for name, process in nodes.items():
            assert process.wait(timeout=30) == 0, (tmp_path / name).read_text()
            assert "Traceback" not in (tmp_path / name).read_text()


def test_the_tests_run_in_the_workspace(workspace: Workspace) -> None:
    """The sources there are not compiled: what was installed is."""
    tests = workspace.source / "test"
    shutil.copytree(ROOT / "test" / "loops", tests / "loops")
    shutil.copy(ROOT / "test" / "conftest.py", tests)
    folder = workspace.prefix.parent.parent
    bases = [f"--{name}-base={folder / name}" for name in ("build", "install")]
    command = [str(COLCON), f"--log-base={folder / 'log'}", "test", *bases]
    command += [f"--base-paths={workspace.source}", "--return-code-on-test-failure"]
    done = subprocess.run(
        command, cwd=folder, env=workspace.environment, capture_output=True, text=True
    )
    assert done.returncode == 0, done.stdout + done.stderr
    results = ElementTree.parse(folder / "build" / "lagrangian_ff" / "pytest.xml").getroot()
    suite = next(results.iter("testsuite"))
    assert int(suite.get("tests", "0")) > 10
    assert suite.get("failures") == suite.get("errors") == "0"


def test_a_symlinked_build_runs_the_sources_themselves(tmp_path: Path) -> None:
    built = build(tmp_path, "--symlink-install")
    place = Path(built.python("import lagrangian_ff; print(lagrangian_ff.__file__)"))
    assert place.resolve() == (built.source / "lagrangian_ff" / "__init__.py").resolve()
    folder = built.prefix / "lib" / "lagrangian_ff"
    assert {file.name for file in folder.iterdir()} >= EXECUTABLES
