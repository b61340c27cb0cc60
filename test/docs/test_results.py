"""Tables of docs/studies.md whose cases are kept in docs/results: each is made from its lines."""

import json
from pathlib import Path
from typing import Any

import pytest

from lagrangian_ff.studies.decide.study import DecideStudy
from lagrangian_ff.studies.study import Request

DOCS = Path(__file__).resolve().parents[2] / "docs"
STUDIES = {"decide": DecideStudy}


def lines_of(name: str) -> list[dict[str, Any]]:
    """Return the lines of a study that are kept."""
    text = (DOCS / "results" / f"{name}.jsonl").read_text(encoding="utf-8")
    return [json.loads(line) for line in text.splitlines()]


@pytest.mark.parametrize("name", STUDIES)
def test_the_table_is_that_of_the_lines(name: str, tmp_path: Path) -> None:
    study, lines = STUDIES[name](Request(), tmp_path), lines_of(name)
    table = "\n".join(study.results(lines).table())
    shown = (DOCS / "studies.md").read_text(encoding="utf-8")
    assert f"```text\n{table}\n```" in shown, table
    cases = [line["case"] for line in lines]
    assert len(set(cases)) == len(cases)
    assert set(cases) <= {case.name for case in study.every_case()}
    assert not [line["case"] for line in lines if "failed" in line]
