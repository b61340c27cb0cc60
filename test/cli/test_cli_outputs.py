"""Outputs are whole or absent, and what was there is kept."""

import json
import math
import re
import shlex
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from cli_examples import arm, command, csv, lagrangian_ff
from hypothesis import given
from hypothesis import strategies as st

from lagrangian_ff.cli.common.console import Console, progress_bar
from lagrangian_ff.cli.common.options import assignments, names
from lagrangian_ff.cli.common.outputs import (
    check_file,
    check_folder,
    whole,
    write_record,
    write_table,
)
from lagrangian_ff.errors import UserError


@pytest.mark.parametrize(("name", "replaced"), [("metadata.yaml", True), ("identify.yaml", False)])
def test_only_a_bag_is_replaced_by_a_bag(name: str, replaced: bool, tmp_path: Path) -> None:
    path = tmp_path / "config"
    path.mkdir()
    (path / name).touch()
    if replaced:
        check_folder(path, "--output", "bag", force=True)
    else:
        with pytest.raises(UserError, match="is not a bag"):
            check_folder(path, "--output", "bag", force=True)


def test_a_place_that_cannot_be_written_is_a_users_error(tmp_path: Path) -> None:
    with pytest.raises(UserError, match="cannot be written"), whole(tmp_path / "no" / "file"):
        pass


def test_two_outputs_of_one_name(tmp_path: Path) -> None:
    path = tmp_path / "a.npz"
    with pytest.raises(UserError, match="something else"):
        check_file(path, "--json", force=True, keep=[tmp_path / "." / "a.npz"])


def test_numbers_that_json_has_no_word_for_become_null(tmp_path: Path) -> None:
    path = tmp_path / "found.json"
    write_record(str(path), {"a": math.nan, "b": [1.0, math.inf], "c": {"d": "N·m"}, "e": (2,)})
    assert json.loads(path.read_text()) == {
        "a": None,
        "b": [1.0, None],
        "c": {"d": "N·m"},
        "e": [2],
    }
    write_record(None, {})


def test_a_table_reads_back_to_the_same_numbers(tmp_path: Path) -> None:
    values = np.random.default_rng(0).normal(size=(50, 2)) * 1e-3
    write_table(tmp_path / "t.csv", values[:, 0], {"effort": values[:, 1:]}, ["a"])
    lines = (tmp_path / "t.csv").read_text().splitlines()
    assert lines[0] == "time,effort/a"
    assert np.array_equal(np.loadtxt(lines[1:], delimiter=","), values)


def test_a_note_is_shown_once(capsys: pytest.CaptureFixture[str]) -> None:
    console = Console()
    for _ in range(3):
        console.note("the bag was cut off")
    assert capsys.readouterr().out == "note: the bag was cut off\n"


def test_text_gives_way_to_json_on_standard_output(capsys: pytest.CaptureFixture[str]) -> None:
    Console("-").say("text")
    Console("file.json").say("other")
    captured = capsys.readouterr()
    assert (captured.out, captured.err) == ("other\n", "text\n")


def test_short_work_is_not_mentioned_in_a_log(capsys: pytest.CaptureFixture[str]) -> None:
    with progress_bar("reading") as progress:
        progress(0.5, "half")
    assert capsys.readouterr().err == ""
    with progress_bar("reading") as progress:
        progress(0.5, "half")
        time.sleep(2.1)
        progress(0.6, "more")
        progress(0.7, "still more")
    assert capsys.readouterr().err == "reading ...\nreading: 2 s\n"


def test_a_terminal_gets_a_bar(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("TERM", "xterm")
    monkeypatch.setenv("FORCE_COLOR", "1")
    monkeypatch.setattr("sys.stderr.isatty", lambda: True)
    with progress_bar("reading") as progress:
        progress(1.0, "the end [of] it")
    assert "reading: the end [of] it" in capsys.readouterr().err


@given(
    st.dictionaries(
        st.text("abc_/-=", min_size=1).filter(lambda name: name.strip("=")),
        st.floats(allow_nan=False, allow_infinity=False),
    )
)
def test_joints_with_any_name_take_values(values: dict[str, float]) -> None:
    texts = [f"{joint}={value!r}" for joint, value in values.items()]
    assert assignments("--x", texts) == values
    assert assignments("--x", [",".join(texts)]) == values


def test_names_come_one_by_one_or_joined() -> None:
    assert names(["a,b", " c ", "d,"]) == ("a", "b", "c", "d")


def test_sources_swallowed_by_joints_are_explained(tmp_path: Path) -> None:
    outcome = lagrangian_ff("identify", "--output", tmp_path / "m.npz", "--joints", "a", "bag")
    assert outcome.code == 2
    assert "put SOURCE first: what follows --joints or" in outcome.err


def closed(arguments: str, redirection: str, folder: Path) -> subprocess.CompletedProcess[str]:
    """Run a command in a shell that closes or pipes its streams."""
    words = " ".join(map(shlex.quote, command()))
    text = f"set -o pipefail; {words} {arguments} {redirection}"
    return subprocess.run(
        ["bash", "-c", text], cwd=folder, capture_output=True, text=True, timeout=120
    )


@pytest.mark.parametrize("redirection", [">&-", "2>&-", ">&- 2>&-", "| head -1", "| true", "<&-"])
@pytest.mark.parametrize("arguments", ["effects", "--help", "effects coulomb --json -"])
def test_closed_streams_are_no_failure(arguments: str, redirection: str, tmp_path: Path) -> None:
    found = closed(arguments, redirection, tmp_path)
    assert found.returncode == 0
    assert not re.search("Traceback|Error:|error:", found.stderr)


def test_a_reader_that_leaves_does_not_end_the_work(tmp_path: Path) -> None:
    csv(tmp_path / "arm.csv", arm(8.0))
    found = closed("identify arm.csv --samples 40 --output model.npz", "| head -1", tmp_path)
    assert (found.returncode, found.stderr) == (0, "")
    assert (tmp_path / "model.npz").is_file()


@pytest.mark.parametrize(
    "place", ["/proc/model.npz", "/dev/null/model.npz", f"{'x' * 260}.npz", "no/model.npz"]
)
def test_a_place_that_cannot_be_written_is_refused_before_the_work(
    place: str, tmp_path: Path
) -> None:
    (tmp_path / "arm.csv").write_text("no recording: reading it would fail in other words")
    found = lagrangian_ff("identify", tmp_path / "arm.csv", "--output", place)
    assert found.code == 2
    assert found.err.startswith(("error: --output", "error: xxx"))


def test_two_commands_do_not_write_one_output(tmp_path: Path) -> None:
    csv(tmp_path / "arm.csv", arm(8.0))
    (tmp_path / "other").symlink_to(tmp_path)
    held = "import sys, time; from pathlib import Path; "
    held += "from lagrangian_ff.cli.common.outputs import check_file; "
    held += "check_file(Path(sys.argv[1]), '--output', force=False); print(flush=True); "
    held += "time.sleep(60)"
    target = tmp_path / "other" / "model.npz"
    arguments = "identify", tmp_path / "arm.csv", "--samples", "40", "--output"
    with subprocess.Popen(
        [sys.executable, "-c", held, str(target)], stdout=subprocess.PIPE
    ) as other:
        assert other.stdout is not None
        other.stdout.readline()
        for more in ((), ("--force",)):
            found = lagrangian_ff(*arguments, tmp_path / "model.npz", *more)
            assert found.code == 2
            assert "another command that runs now is about to write it" in found.err
        other.kill()
    assert lagrangian_ff(*arguments, tmp_path / "model.npz").code == 0
    assert lagrangian_ff(*arguments, tmp_path / "model.npz", "--force").code == 0
    assert sorted(path.name for path in tmp_path.iterdir()) == ["arm.csv", "model.npz", "other"]
