"""`study consistency`: errors that end at the noise, and at what friction the model cannot be."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from lagrangian_ff.cli.main import main
from lagrangian_ff.studies.consistency import SCENE, ConsistencyStudy, Growing, bound
from lagrangian_ff.studies.robots import draw_samples
from lagrangian_ff.studies.study import Request


def test_the_error_falls_with_samples_unless_friction_is_missing(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = tmp_path / "study"
    command = ["study", "consistency", "--quick", "--robots", "1", "--jobs", "1"]
    assert main([*command, "--models", "chain+fri", "chain", "--output", str(folder)]) == 0
    assert "bound (50)" in capsys.readouterr().out
    numbers = json.loads((folder / "summary.json").read_text())
    knowing, without = numbers["models"]["chain+fri"], numbers["models"]["chain"]
    assert knowing["samples"] == [25, 100]
    assert knowing["error"][1] < 0.6 * knowing["error"][0]
    assert without["error"][1] > 5.0 * knowing["error"][1]
    assert without["bound"] > 30.0 * knowing["bound"]
    assert (folder / "consistency.png").stat().st_size > 10_000


def test_the_bound_is_the_friction_that_the_basis_cannot_be() -> None:
    samples = draw_samples(replace(SCENE, validation=3000), 0, 2, 0)
    assert bound(samples, with_basis=False) == pytest.approx(
        np.sqrt(np.mean(samples.asked_friction**2))
    )
    # A sharp sign is all but in the basis; a square is not.
    assert bound(samples, with_basis=True) < 0.03 * bound(samples, with_basis=False)
    bent = replace(samples, asked_friction=samples.asked.qd * np.abs(samples.asked.qd))
    left = bound(bent, with_basis=True) / bound(bent, with_basis=False)
    assert 0.05 < left < 0.5


def line(samples: int, model: str, error: float, limit: float) -> dict[str, object]:
    return {
        "case": f"m{samples:04d}-robot00-{model}", "samples": samples, "robot": 0,
        "model": model, "error": error, "bound": limit,
    }  # fmt: skip


def test_findings_say_what_holds_and_what_does_not(tmp_path: Path) -> None:
    study = ConsistencyStudy(Request(), tmp_path)
    results = study.results(
        [
            line(25, "chain+fri", 0.1, 0.0), line(400, "chain+fri", 0.01, 0.0),
            line(25, "rbf+fri", 0.1, 0.0), line(400, "rbf+fri", 0.05, 0.0),
            line(25, "chain", 0.5, 0.3), line(400, "chain", 0.29, 0.3),
            line(25, "vrbf", 0.5, 0.3), line(400, "vrbf", 0.4, 0.3),
            {"case": "m0025-robot00-rbfs", "failed": "broken"},
        ]
    )  # fmt: skip
    findings = results.record()["findings"]
    assert {name: each["holds"] for name, each in findings.items()} == {
        "chain+fri": True, "rbf+fri": False, "chain": True, "vrbf": False,
    }  # fmt: skip
    text = "\n".join(results.table())
    assert "0.1 with 25 samples, 0.01 with 400" in text
    assert "broken" in text
    results.figure()
    study.results([]).figure()


def test_cases_are_named_after_samples_robot_and_model() -> None:
    assert Growing(SCENE, None, 0, 2, 3, "vrbfs+fri").name == "m0500-robot03-vrbfs+fri"
