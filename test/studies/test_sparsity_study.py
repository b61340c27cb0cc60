"""`study sparsity`: what fewer centres cost, and what they save."""

import json
from pathlib import Path

import pytest

from lagrangian_ff.cli.main import main
from lagrangian_ff.studies.sparsity import SparsityStudy
from lagrangian_ff.studies.study import Request


def test_centres_are_compared_with_and_without_the_other_samples(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = tmp_path / "study"
    assert main(["study", "sparsity", "--quick", "--jobs", "1", "--output", str(folder)]) == 0
    assert "vrbfs+fri, centres alone" in capsys.readouterr().out
    curves = json.loads((folder / "summary.json").read_text())["curves"]["vrbfs+fri"]
    every, alone = curves["landmarks"], curves["samples"]
    assert every["centres"] == alone["centres"] == [10, 40]
    # Ten samples are too few to learn from; as landmarks for all the others they are not.
    assert every["rmse"][0] < 0.9 * alone["rmse"][0]
    lines = [json.loads(text) for text in (folder / "cases.jsonl").read_text().splitlines()]
    assert {line["learned_from"] for line in lines if line["exact"]} == {10, 40}
    assert min(line["learned_from"] for line in lines if not line["exact"]) > 400
    assert (folder / "sparsity.png").stat().st_size > 10_000


def line(centres: int, exact: bool, rmse: float) -> dict[str, object]:
    return {
        "case": f"{centres}-{exact}", "model": "vrbfs+fri", "centres": centres, "exact": exact,
        "rmse": rmse, "fitting": 0.1, "predicting": 0.1,
    }  # fmt: skip


def test_findings_name_how_many_are_enough_and_whether_more_data_helped(tmp_path: Path) -> None:
    study = SparsityStudy(Request(), tmp_path)
    lines = [line(10, False, 2.0), line(20, False, 1.05), line(40, False, 1.0)]
    lines += [line(10, True, 3.0), line(20, True, 2.0), line(40, True, 0.9)]
    found = study.results(lines).record()["findings"]
    assert found["vrbfs+fri enough"]["landmarks"] == 20
    assert found["vrbfs+fri enough"]["holds"]
    assert not found["vrbfs+fri more data"]["holds"]
    assert found["vrbfs+fri more data"]["most"] == pytest.approx(1.0 / 0.9)
    assert study.results(lines[:2]).findings == {}
    study.results(lines).figure()
    study.results([]).figure()
