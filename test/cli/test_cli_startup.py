"""What commands import: no more than they use, so that they answer at once."""

import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

import pytest
from cli_examples import arm, csv, small_model

from lagrangian_ff.cli.commands import COMMANDS
from lagrangian_ff.recording import write_bag, write_npz

NAMES = [command.NAME for command in COMMANDS]
DRAWING = {"matplotlib", "plotly", "rich"}
ELSEWHERE = {"pybullet", "rclpy", "joblib", "distributed", "pinocchio"}
BAGS = {"rosbags", "mcap", "ruamel.yaml", "zstandard", "lz4"}
SCIPY = {
    f"scipy.{part}"
    for part in ("linalg", "special", "optimize", "interpolate", "signal", "stats", "sparse")
}
LISTED = "import scipy.linalg, sys; print(*sys.modules)"
WITH_LINALG = subprocess.run([sys.executable, "-c", LISTED], capture_output=True, text=True).stdout
SLOW_OF_SCIPY = SCIPY - set(WITH_LINALG.split())

RUN = """
import sys
from lagrangian_ff.cli.main import main
try:
    code = main(sys.argv[1:])
except SystemExit as end:
    code = end.code
print(*sys.modules, sep="\\n", file=sys.stderr)
sys.exit(code)
"""


OPTIONAL = ("pybullet", "mcap", "zstandard", "lz4", "threadpoolctl", "pinocchio", "distributed")


def imported(*arguments: object, without: Sequence[str] = ()) -> set[str]:
    """Return the modules that a command has imported when it is done, without some libraries."""
    hide = f"import sys; sys.modules |= dict.fromkeys({list(without)!r})"
    done = subprocess.run(
        [sys.executable, "-c", hide + RUN, *map(str, arguments)],
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return set(done.stderr.splitlines())


@pytest.fixture(scope="module")
def files(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """Return a model and recordings."""
    folder = tmp_path_factory.mktemp("startup")
    recording = arm()
    return {
        "model": small_model(folder / "model.npz"),
        "csv": csv(folder / "arm.csv", recording),
        "npz": write_npz(folder / "arm.npz", recording),
        "bag": write_bag(folder / "arm", recording),
    }


@pytest.mark.parametrize("arguments", [[], *([name] for name in NAMES)], ids=str)
def test_help_imports_not_even_numpy(arguments: list[str]) -> None:
    assert not imported(*arguments, "--help") & {"numpy", "numba", "scipy", *DRAWING, *ELSEWHERE}


@pytest.mark.parametrize("arguments", [[], ["stribeck"], ["--json", "-"]], ids=str)
def test_the_catalogue_needs_no_library_but_numpy(arguments: list[str]) -> None:
    assert not imported("effects", *arguments) & (SCIPY | DRAWING | ELSEWHERE | BAGS)


@pytest.mark.parametrize("command", ["history", "info"])
def test_a_model_is_told_of_without_solving_drawing_or_reading_bags(
    command: str, files: dict[str, Path]
) -> None:
    found = imported(command, files["model"], "--json", "-")
    assert not found & (SCIPY | DRAWING | ELSEWHERE | BAGS)
    assert not any(name.startswith("lagrangian_ff.diagnosis") for name in found)


def test_a_page_of_a_history_needs_no_library_either(
    files: dict[str, Path], tmp_path: Path
) -> None:
    found = imported("history", files["model"], "--report", tmp_path / "page.html")
    assert not found & (SCIPY | DRAWING | ELSEWHERE | BAGS)


@pytest.mark.parametrize("kind", ["csv", "npz", "bag"])
def test_a_recording_is_looked_at_without_the_slow_parts_of_scipy(
    kind: str, files: dict[str, Path]
) -> None:
    found = imported("info", files[kind])
    assert not found & (SLOW_OF_SCIPY | DRAWING | ELSEWHERE)
    if kind != "bag":
        assert not found & {"rosbags", "mcap", "ruamel.yaml"}


def test_a_model_is_compared_without_the_slow_parts_of_scipy(
    files: dict[str, Path], tmp_path: Path
) -> None:
    found = imported("compare", files["model"], files["csv"], "--report", tmp_path / "page.html")
    assert not found & (SLOW_OF_SCIPY | DRAWING | ELSEWHERE)


@pytest.mark.parametrize("kind", ["csv", "bag"])
def test_from_a_recording_to_what_is_missing_without_an_optional_library(
    kind: str, files: dict[str, Path], tmp_path: Path
) -> None:
    model = tmp_path / "model.npz"
    imported("identify", files[kind], "--output", model, "--samples", "40", without=OPTIONAL)
    page = tmp_path / "page.html"
    imported("diagnose", model, files[kind], "--report", page, without=OPTIONAL)
    assert page.exists()


@pytest.mark.parametrize("node", ["feedforward", "monitor", "identify"])
def test_a_node_imports_no_slow_part_of_scipy(node: str) -> None:
    pytest.importorskip("rclpy", reason="rclpy is not installed")
    code = f"import sys, lagrangian_ff.nodes.{node}; print(*sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert not set(done.stdout.split()) & (
        SLOW_OF_SCIPY | DRAWING | {"pybullet", "rosbags.rosbag2"}
    )
