"""`compare` on the command line."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from cli_examples import JOINTS, arm, assert_refused, csv, lagrangian_ff, process, small_model

from lagrangian_ff.recording import Recording


@pytest.fixture(scope="module")
def model(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the file of a model of the small arm."""
    return small_model(tmp_path_factory.mktemp("compare") / "model.npz")


def changed(seconds: float = 30.0) -> Recording:
    """The small arm, its elbow grown sticky at low speed."""
    recording = arm(seconds, reach=0.9)
    assert recording.velocity is not None
    qd = recording.velocity[:, 1]
    effort = recording.effort.copy()
    effort[:, 1] += 3.0 * np.tanh(qd / 0.02) * np.exp(-((qd / 0.15) ** 2))
    return replace(recording, effort=effort)


def test_what_changed_is_said_in_words_and_as_json(model: Path, tmp_path: Path) -> None:
    source = csv(tmp_path / "changed.csv", changed())
    outcome = process("compare", model, source, "--json", tmp_path / "where.json")
    assert outcome.code == 0, outcome
    assert "elbow below 0." in outcome.out
    assert f"lagrangian_ff diagnose {model} {source}" in outcome.text
    record = json.loads((tmp_path / "where.json").read_text())
    assert set(record["joints"]) == set(JOINTS)
    region = record["regions"][0]
    assert region["joint"] == "elbow"
    assert region["coordinate"] == "velocity"
    assert region["low"] < 0.0 < region["high"] < 0.6
    assert region["share_of_error"] > 2.0 * region["share_of_time"]


def test_a_model_that_is_surer_than_it_should_be_is_told(model: Path, tmp_path: Path) -> None:
    recording = arm(30.0, reach=0.9)
    same = json.loads(
        lagrangian_ff("compare", model, csv(tmp_path / "same.csv", recording), "--json", "-").out
    )
    assert min(same["covered"].values()) > 0.75
    assert same["too_sure"] == ""
    assert recording.velocity is not None
    effort = recording.effort + [0.0, 1.0] * np.sign(recording.velocity)
    grown = csv(tmp_path / "grown.csv", replace(recording, effort=effort))
    outcome = lagrangian_ff("compare", model, grown, "--json", "-")
    covered = json.loads(outcome.out)["covered"]
    assert covered["elbow"] < 0.5
    assert covered["shoulder"] == same["covered"]["shoulder"]
    assert f"only {covered['elbow']:.0%} of elbow lie inside its 90% intervals" in outcome.text


def test_the_error_is_that_of_predict(model: Path, tmp_path: Path) -> None:
    source = csv(tmp_path / "changed.csv", changed())
    errors = [
        json.loads(lagrangian_ff(command, model, source, "--json", "-").out)["joints"]
        for command in ("compare", "predict")
    ]
    assert errors[0] == errors[1]


def test_several_recordings_are_judged_together(model: Path, tmp_path: Path) -> None:
    sources = [csv(tmp_path / f"{k}.csv", changed(10.0 + k)) for k in range(2)]
    together = json.loads(lagrangian_ff("compare", model, *sources, "--json", "-").out)
    apart = [json.loads(lagrangian_ff("compare", model, one, "--json", "-").out) for one in sources]
    assert together["samples"] == sum(one["samples"] for one in apart)
    assert together["blocks"][-1]["end"] > apart[0]["blocks"][-1]["end"] + 5.0
    assert together["sources"] == [str(source) for source in sources]


def test_the_page_is_whole_or_not_there(model: Path, tmp_path: Path) -> None:
    source = csv(tmp_path / "changed.csv", changed(8.0))
    page = tmp_path / "where.html"
    assert_refused(lagrangian_ff("compare", model, source, "--report", tmp_path / "a.txt"), ".html")
    outcome = lagrangian_ff("compare", model, source, "--report", page)
    assert outcome.code == 0, outcome
    assert page.read_text("utf-8").endswith("</html>\n")
    assert_refused(lagrangian_ff("compare", model, source, "--report", page), "exists already")
    assert lagrangian_ff("compare", model, source, "--report", page, "--force").code == 0
    assert sorted(path.name for path in tmp_path.iterdir()) == ["changed.csv", "where.html"]


def test_a_short_recording_is_said_to_be_short(model: Path, tmp_path: Path) -> None:
    outcome = lagrangian_ff("compare", model, csv(tmp_path / "short.csv", arm(2.0)))
    assert outcome.code == 0, outcome
    assert "too short to tell where the error lies" in outcome.text


def test_wrong_sources(model: Path, tmp_path: Path) -> None:
    other = csv(tmp_path / "arm.csv", arm(4.0, joints=("shoulder", "wrist")))
    assert_refused(lagrangian_ff("compare", model, other), "model.npz", "elbow", "wrist")
    assert_refused(lagrangian_ff("compare", model, tmp_path / "none"), "none")
    source = csv(tmp_path / "right.csv", arm(4.0))
    refused = lagrangian_ff("compare", model, source, "--json", source, "--force")
    assert_refused(refused, "right.csv")
