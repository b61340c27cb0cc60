"""`history` on the command line: how a model came to be what it is."""

import json
from pathlib import Path

import pytest
from cli_examples import JOINTS, assert_refused, lagrangian_ff, small_model

from lagrangian_ff.cli.text.history import before_after_table
from lagrangian_ff.identification.history import ErrorChange


@pytest.fixture(scope="module")
def model(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the file of a model to which dry friction was added."""
    folder = tmp_path_factory.mktemp("history")
    old = small_model(folder / "old.npz", "--model", "chain+viscous")
    outcome = lagrangian_ff(
        "add", old, "coulomb", "--joint", "shoulder", "--output", folder / "model.npz"
    )
    assert outcome.code == 0, outcome
    return folder / "model.npz"


def test_every_step_is_told(model: Path, tmp_path: Path) -> None:
    page = tmp_path / "history.html"
    outcome = lagrangian_ff("history", model, "--json", tmp_path / "history.json", "--report", page)
    assert outcome.code == 0, outcome
    record = json.loads((tmp_path / "history.json").read_text())
    identified, added = record["steps"]
    assert identified["error_before"] is None
    assert added["error_before"] == identified["error_after"]
    assert added["error_after"] < added["error_before"]
    for joint in JOINTS:
        assert f"{added['joints'][joint]['after']:.3g}"[:4] in outcome.out
    for words in ("identified", "coulomb on shoulder", "added by hand", added["judged_on"]):
        assert words in outcome.text
    assert page.read_text("utf-8").endswith("</html>\n")


def test_outputs_are_kept_and_other_files_refused(model: Path, tmp_path: Path) -> None:
    kept = tmp_path / "kept.html"
    kept.write_text("precious")
    assert_refused(lagrangian_ff("history", model, "--report", kept), "kept.html", "exists already")
    assert kept.read_text() == "precious"
    assert_refused(lagrangian_ff("history", kept), "kept.html")
    assert_refused(lagrangian_ff("history", tmp_path / "none.npz"), "none.npz")


def test_the_fall_of_an_error_is_shown_with_its_sign() -> None:
    lines = before_after_table({"a": ErrorChange(2.0, 1.0), "b": ErrorChange(1.0, 1.1)})
    assert lines[1].endswith("-50.0 %")
    assert lines[2].endswith("+10.0 %")
