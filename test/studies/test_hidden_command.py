"""`lagrangian_ff study hidden`: what it names, writes and refuses."""

import json
from functools import partial
from pathlib import Path
from typing import Any

import pytest

from lagrangian_ff.cli.main import main
from lagrangian_ff.studies.hidden import plants, study
from lagrangian_ff.studies.hidden.cases import cases


class Silent:
    """A diagnosis that never finds anything."""

    def identify(self, motion: Any) -> None:
        """Know nothing."""

    def diagnose(self, model: None, motion: Any, confirm: Any) -> dict[str, Any]:
        return {"verdict": "at the noise floor", "findings": []}

    def add(self, model: None, effect: str, joint: str, shape: Any = None) -> None:
        """Learn nothing."""

    def errors(self, model: None, motion: Any) -> dict[str, float]:
        return dict.fromkeys(motion.joints, 1.0)


@pytest.fixture
def short(monkeypatch: pytest.MonkeyPatch) -> None:
    stretches = plants.Stretches(((6, 4.0),))
    short = partial(study.HiddenStudy, examined=Silent(), stretches=stretches)
    monkeypatch.setattr(study, "HiddenStudy", short)


def test_it_lists_the_cases_without_doing_them(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = str(tmp_path / "study")
    assert main(["study", "hidden", "--output", folder, "--list", "--small"]) == 0
    assert capsys.readouterr().out.split() == [case.name for case in cases(small=True)]
    assert not (tmp_path / "study").exists()


@pytest.mark.usefixtures("short")
def test_it_leaves_lines_numbers_and_a_picture(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = tmp_path / "study"
    command = ["study", "hidden", "--output", str(folder), "--quick", "--cases", "clean-00"]
    assert main([*command, "--json", str(tmp_path / "found.json")]) == 0
    out = capsys.readouterr().out
    assert "nothing hidden: 0 of 1 with a confirmed effect" in out
    assert {"cases.jsonl", "summary.json", "hidden.png", "study.json"} <= {
        path.name for path in folder.iterdir()
    }
    numbers = json.loads((folder / "summary.json").read_text())
    assert numbers == json.loads((tmp_path / "found.json").read_text())
    assert (numbers["cases"], numbers["clean"]["wrong"]) == (1, 0)
    held = (folder / "cases.jsonl").read_bytes()
    assert main(command) == 0
    assert (folder / "cases.jsonl").read_bytes() == held


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--cases", "nonsense"], "no case is named 'nonsense'"),
        (["--seed", "-1"], "--seed -1"),
        (["--jobs", "0"], "jobs is 0"),
    ],
)
def test_mistakes_are_told_in_one_line(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], options: list[str], message: str
) -> None:
    assert main(["study", "hidden", "--output", str(tmp_path / "study"), *options]) == 2
    error = capsys.readouterr().err
    assert message in error
    assert error.count("\n") == 1
