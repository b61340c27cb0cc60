"""The entry point: help, versions, exit codes, and how every run ends."""

import subprocess
import sys
from pathlib import Path

import pytest
from cli_examples import arm, command, csv, interrupted, lagrangian_ff, process

from lagrangian_ff import __version__
from lagrangian_ff.cli.commands import COMMANDS
from lagrangian_ff.cli.commands import info as info_command
from lagrangian_ff.errors import ModelError

NAMES = [command.NAME for command in COMMANDS]


def test_the_installed_command_tells_its_version() -> None:
    outcome = process("--version")
    assert (outcome.code, outcome.out) == (0, f"lagrangian_ff {__version__}\n")


def test_help_lists_every_command() -> None:
    outcome = lagrangian_ff("--help")
    assert outcome.code == 0
    for command_ in COMMANDS:
        assert f"    {command_.NAME}" in outcome.out
        assert command_.SUMMARY in outcome.text


@pytest.mark.parametrize("name", NAMES)
def test_help_of_each_command_teaches(name: str) -> None:
    outcome = lagrangian_ff(name, "--help")
    assert outcome.code == 0
    assert "example" in outcome.out
    assert f"  lagrangian_ff {name} " in outcome.out
    assert max(map(len, outcome.out.splitlines())) <= 100


def test_help_loads_no_library() -> None:
    heavy = ("numpy", "scipy", "rich", "rosbags", "pybullet", "rclpy")
    code = (
        "import sys\nfrom lagrangian_ff.cli.main import main\n"
        "try:\n    main(['identify', '--help'])\nexcept SystemExit:\n    pass\n"
        f"print('loaded:', [name for name in {heavy} if name in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.splitlines()[-1] == "loaded: []"


@pytest.mark.parametrize(
    "arguments", [(), ("identfy",), ("identify",), ("info",), ("info", "x", "--nonsense")]
)
def test_wrong_usage_ends_with_2_and_says_where_to_read(arguments: tuple[str, ...]) -> None:
    outcome = lagrangian_ff(*arguments)
    assert outcome.code == 2
    assert outcome.out == ""
    assert "error: " in outcome.err
    assert "--help" in outcome.err


def test_an_option_that_is_not_there_is_answered_by_its_command() -> None:
    outcome = lagrangian_ff("compare", "model.npz", "bag", "--jsn", "--nothing-like-it")
    assert outcome.code == 2
    usage, error, hint = outcome.err.splitlines()
    assert usage.startswith("usage: lagrangian_ff compare MODEL")
    assert error.endswith("unrecognized arguments: --jsn --nothing-like-it; is --json meant?")
    assert hint == "read on: lagrangian_ff compare --help"


def test_a_user_error_is_one_line_on_standard_error(tmp_path: Path) -> None:
    outcome = process("info", tmp_path / "nothing.csv")
    assert outcome.code == 2
    assert outcome.out == ""
    assert outcome.err == f"error: {tmp_path / 'nothing.csv'}: no such file or directory\n"


def test_the_module_runs_as_the_command_does(tmp_path: Path) -> None:
    done = subprocess.run(
        [sys.executable, "-m", "lagrangian_ff.cli", "--version"],
        capture_output=True,
        text=True,
        check=True,
    )
    assert done.stdout == process("--version").out


@pytest.mark.parametrize(
    ("error", "words"),
    [
        (ModelError("what went wrong"), "error: what went wrong\n"),
        (OSError(28, "No space left on device", "out.csv"),
         "error: out.csv: No space left on device\n"),
        (KeyboardInterrupt(), "interrupted\n"),
    ],
)  # fmt: skip
def test_how_errors_are_said(
    error: BaseException, words: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(*_: object) -> int:
        raise error

    monkeypatch.setattr(info_command, "run", fail)
    outcome = lagrangian_ff("info", "x")
    assert outcome.code == (130 if isinstance(error, KeyboardInterrupt) else 2)
    assert outcome.err == words


def test_a_mistake_of_ours_is_not_hidden(monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(*_: object) -> int:
        raise ZeroDivisionError

    monkeypatch.setattr(info_command, "run", fail)
    with pytest.raises(ZeroDivisionError):
        lagrangian_ff("info", "x")


def test_a_reader_that_leaves_a_pipe_is_no_error(tmp_path: Path) -> None:
    source = csv(tmp_path / "arm.csv", arm(seconds=3.0))
    script = " ".join(command())
    done = subprocess.run(
        ["bash", "-c", f"set -o pipefail; {script} info {source} | true"],
        capture_output=True,
        text=True,
        check=False,
        timeout=60,
    )
    assert done.stderr == ""
    assert done.returncode == 0


def test_ctrl_c_ends_with_130_and_leaves_nothing(tmp_path: Path) -> None:
    source = csv(tmp_path / "arm.csv", arm())
    folder = tmp_path / "out"
    folder.mkdir()
    output = folder / "model.npz"
    outcome = interrupted(
        "note: low-pass", "identify", source, "--output", output, "--samples", "2000"
    )
    assert outcome.code == 130
    assert outcome.err.splitlines()[-1] == "interrupted"
    assert "Traceback" not in outcome.err
    assert list(folder.iterdir()) == []
