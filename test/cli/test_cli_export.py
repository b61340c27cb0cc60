"""`export`: what is written, said and refused."""

import json
from pathlib import Path

import pytest
from cli_examples import assert_refused, lagrangian_ff, small_model

DRIFTS = ("--model", "chain+fri+drift")


@pytest.fixture(scope="module")
def model(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A model of the small arm."""
    return small_model(tmp_path_factory.mktemp("export") / "model.npz", "--model", "chain+fri")


def test_a_library_is_written_and_its_cost_is_said(model: Path, tmp_path: Path) -> None:
    outcome = lagrangian_ff(
        "export", model, "--to", "c", "--output", tmp_path / "arm", "--json", tmp_path / "f.json"
    )
    assert outcome.code == 0, outcome
    assert (tmp_path / "arm" / "arm.h").is_file()
    assert "saved:" in outcome.text
    assert "shoulder" in outcome.text
    record = json.loads((tmp_path / "f.json").read_text())
    assert record["format"] == "c"
    assert record["losses"] == []
    assert max(record["difference"]) < 1e-9
    assert record["error"] == pytest.approx(record["model_error"])


def test_only_a_library_is_replaced_and_only_by_force(model: Path, tmp_path: Path) -> None:
    output = tmp_path / "arm"
    command = ("export", model, "--to", "c", "--output", output)
    assert lagrangian_ff(*command).code == 0
    assert_refused(lagrangian_ff(*command), "arm", "--force")
    assert lagrangian_ff(*command, "--force").code == 0
    other = tmp_path / "mine"
    other.mkdir()
    (other / "thesis.txt").touch()
    assert_refused(lagrangian_ff(*command[:-1], other, "--force"), "mine", "not a library")
    assert (other / "thesis.txt").exists()


def test_what_cannot_be_exported_is_refused_and_nothing_is_left(
    model: Path, tmp_path: Path
) -> None:
    drifting = small_model(tmp_path / "drift.npz", *DRIFTS)
    output = tmp_path / "arm.json"
    command = ("export", drifting, "--to", "json", "--output", output)
    assert_refused(lagrangian_ff(*command), "drift", "--settled")
    assert not output.exists()
    outcome = lagrangian_ff(*command, "--settled")
    assert outcome.code == 0, outcome
    assert "drift, left settled" in outcome.text
    for format_, end in (("matlab", ".m"), ("c", ""), ("json", ".txt"), ("urdf", ".urdf")):
        path = tmp_path / f"No{end}"
        outcome = lagrangian_ff("export", model, "--to", format_, "--output", path)
        assert_refused(outcome, {"matlab": "expected one of", "c": "name of a C library",
                                 "json": ".json", "urdf": "--urdf"}[format_])  # fmt: skip
        assert not path.exists()
