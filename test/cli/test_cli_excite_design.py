"""`excite` for a question: the file, the prediction, and what came of it."""

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from cli_examples import assert_refused, lagrangian_ff, small_model
from diagnosis_examples import diagnosis, finding, run

from lagrangian_ff.arm import read_trajectory
from lagrangian_ff.cli.common.console import Console
from lagrangian_ff.cli.common.designed import outcome_record, promised, say_outcomes
from lagrangian_ff.diagnosis.thresholds import Effort, using
from lagrangian_ff.identification import Model

QUESTION = ("--for", "stribeck@elbow", "--shape", "v_s=0.1", "--duration", "8", "--search", "0.1")


@pytest.fixture(autouse=True, scope="module")
def _few_samples() -> Iterator[None]:
    with using(effort=Effort(1000, ((60, 10), (120, 3), (240, 1)))):
        yield


@pytest.fixture(scope="module")
def model(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a model of the small arm."""
    return small_model(tmp_path_factory.mktemp("model") / "model.npz")


@pytest.fixture(scope="module")
def made(model: Path) -> tuple[Path, str, dict[str, Any]]:
    """Return a designed motion, what was said, and its record."""
    output, record = model.with_name("design.csv"), model.with_name("design.json")
    outcome = lagrangian_ff(
        "excite", *QUESTION, "--model", model, "--output", output, "--json", record,
        "--speed", "elbow=1.5", "--torque", "shoulder=40", "--start", "elbow=0.1",
    )  # fmt: skip
    assert outcome.code == 0, outcome
    return output, outcome.text, json.loads(record.read_text())


def test_the_motion_keeps_the_limits(made: tuple[Path, str, dict[str, Any]], model: Path) -> None:
    output, _, record = made
    found, known = read_trajectory(output), Model.load(model).range
    assert found.joints == ("shoulder", "elbow")
    assert np.all((found.q >= known.q_low) & (found.q <= known.q_high))
    assert np.all(np.abs(found.qdd) <= known.qdd_max)
    assert np.abs(found.qd[:, 1]).max() <= 1.5
    np.testing.assert_allclose(found.q[[0, -1], 1], 0.1, atol=1e-9)
    assert not found.qd[[0, -1]].any()
    assert record["seconds"] == pytest.approx(found.duration)
    assert set(record["used"]) == {"position", "speed", "acceleration", "jerk", "torque"}
    assert all(share <= 1.0 for one in record["used"].values() for share in one.values())


def test_the_prediction_is_said(made: tuple[Path, str, dict[str, Any]]) -> None:
    _, text, record = made
    assert "is stribeck@elbow there?" in text
    assert "nats to decide it, for an effect of 5% of its joint's torque" in text
    assert "cannot know" in text
    every = record["expected"]
    assert every == sorted(every, key=lambda one: -one["nats"])
    mine = next(o for o in every if (o["effect"], o["joint"]) == ("stribeck", "elbow"))
    assert mine["size"] == 0.05
    assert mine["nats"] >= 0.9 * record["nats"] > 0.0
    hidden = [one["effect"] for one in every if one["nats"] < 20.0]
    assert [one["effect"] for one in record["not_shown"]] == hidden


def test_too_little_within_what_was_seen_is_said(model: Path, tmp_path: Path) -> None:
    asked = ("--for", "quadratic_drag@elbow", "--size", "0.001", "--search", "0.1")
    where = ("--model", model, "--duration", "8", "--output", tmp_path / "d.csv")
    outcome = lagrangian_ff("excite", *asked, *where)
    assert outcome.code == 0, outcome
    assert "too little for a claim" in outcome.text
    assert "--speed" in outcome.text


def test_what_came_of_it_is_said(
    made: tuple[Path, str, dict[str, Any]], capsys: pytest.CaptureFixture[str]
) -> None:
    output, _, _ = made
    design = promised(output.with_suffix(".json"))
    found = run(diagnosis(findings=(finding("stribeck", "elbow"),)))
    (outcome,) = outcome_record(design, found)["outcomes"]
    assert (outcome["effect"], outcome["joint"]) == ("stribeck", "elbow")
    assert outcome["promised"] > 0.0
    say_outcomes(design, found, Console())
    assert "promised nats" in capsys.readouterr().out
    assert outcome_record(None, found) == {}


def test_a_file_that_is_no_design(tmp_path: Path, model: Path) -> None:
    wrong = tmp_path / "wrong.json"
    wrong.write_text('{"findings": []}')
    outcome = lagrangian_ff("diagnose", model, model.with_suffix(".csv"), "--expected", wrong)
    assert_refused(outcome, "--expected", "wrong.json", "excite --for")


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ([], ["name one", "--for"]),
        (["chirp", "--everything"], ["name one"]),
        (["--everything"], ["needs --model"]),
        (["--parameters"], ["needs --model"]),
        (["--parameters", "--everything", "--model", "M"], ["not allowed with"]),
        (["--everything", "--arm"], ["needs --model"]),
        (["--for", "stribeck", "--model", "M"], ["expected EFFECT@JOINT"]),
        (["--for", "stribeck@hip", "--model", "M"], ["no joint hip"]),
        (["--for", "stribek@elbow", "--model", "M"], ["no effect 'stribek'"]),
        (["--between", "delay@elbow", "coulomb@elbow", "--model", "M"], ["has coulomb@elbow"]),
        (["--everything", "--model", "M", "--joint", "elbow"], ["--joint is for a template"]),
        (["--everything", "--model", "M", "--shape", "v_s=1"], ["--shape goes with --for"]),
        (["--everything", "--model", "M", "--search", "0"], ["--search 0: expected more than 0"]),
        (["--everything", "--model", "M", "--floor", "0"], ["need --urdf"]),
        (["--everything", "--model", "M", "--speed", "hip=1"], ["--speed: no joint hip"]),
        (["--everything", "--model", "M", "--duration", "1"], ["expected 8 to 60"]),
        (["--everything", "--model", "M", "--size", "7"], ["a size of 7"]),
        (["--everything", "--model", "M", "--arm"], ["--arm: the model is of shoulder, elbow"]),
        (["chirp", "--model", "M", "--jerk", "elbow=1"], ["--jerk is for a designed motion"]),
        (["chirp", "--model", "M", "--arm"], ["--model or --arm, one of them"]),
    ],
)
def test_mistakes(arguments: list[str], words: list[str], model: Path, tmp_path: Path) -> None:
    given = [str(model) if one == "M" else one for one in arguments]
    output = tmp_path / "m.csv"
    assert_refused(lagrangian_ff("excite", *given, "--output", output), *words)
    assert not output.exists()
