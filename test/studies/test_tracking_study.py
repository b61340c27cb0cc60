"""`study tracking`: a small one from the arm to the findings, and what it refuses."""

import json
from pathlib import Path

import numpy as np
import pytest

from lagrangian_ff.arm import simulate
from lagrangian_ff.cli.main import main
from lagrangian_ff.studies.arm import Drive
from lagrangian_ff.studies.study import Request
from lagrangian_ff.studies.tracking import TrackingStudy

QUICK = ["study", "tracking", "--quick", "--jobs", "1", "--output"]


def test_feedforward_lowers_the_error_towards_the_bound(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    models = ["--models", "vrbfs+fri", "auto+fri"]
    assert main([*QUICK, str(tmp_path), "--cases", "speed05-*", *models]) == 0
    numbers = json.loads((tmp_path / "summary.json").read_text())
    error = {name: curve["rmse"][0] for name, curve in numbers["curves"].items()}
    assert list(error) == ["none", "true", "vrbfs+fri", "auto+fri"]
    assert error["true"] < error["auto+fri"] < error["vrbfs+fri"] < error["none"]
    assert error["true"] < 0.05 * error["none"]
    assert [each["holds"] for each in numbers["findings"].values()] == [True, True]
    assert numbers["findings"]["ours_nearest"]["over_bound"]["auto+fri"] == pytest.approx(
        error["auto+fri"] / error["true"]
    )
    assert f"{1e3 * error['none']:.3g}" in capsys.readouterr().out
    line = json.loads((tmp_path / "cases.jsonl").read_text().splitlines()[0])
    by_joint = np.array(list(line["joints"].values()))
    assert line["rmse"] == pytest.approx(np.sqrt(np.mean(by_joint**2)))


def test_the_error_is_that_of_the_simulator() -> None:
    """The recording alone gives it again, which is all that may be kept."""
    drive = Drive(3, 1, 4.0)
    run = simulate(drive.trajectory)
    np.testing.assert_allclose(drive.tracking_error(run.recording), run.tracking_error, atol=1e-12)


def test_nothing_and_the_true_torques_are_always_there(tmp_path: Path) -> None:
    request = Request(quick=True, models=("true", "rbfs"))
    names = [case.name for case in TrackingStudy(request, tmp_path).every_case()]
    assert names == [
        f"speed{speed:02d}-{fed}" for fed in ("none", "true", "rbfs") for speed in (2, 5, 9)
    ]


def test_an_unknown_model_is_reported_in_one_line(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main([*QUICK, str(tmp_path / "study"), "--models", "frictionless"]) == 2
    error = capsys.readouterr().err
    assert "'frictionless' is neither a kernel" in error
    assert error.count("\n") == 1
