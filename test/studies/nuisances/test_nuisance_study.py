"""`study nuisances`: its machinery with a diagnosis that always says the same."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest
from diagnosis_examples import finding

from lagrangian_ff.cli.main import main
from lagrangian_ff.errors import RecordingError, UserError
from lagrangian_ff.recording.motion import Motion
from lagrangian_ff.studies.hidden.study import Answer
from lagrangian_ff.studies.nuisances.plants import cases
from lagrangian_ff.studies.nuisances.study import NuisancesStudy
from lagrangian_ff.studies.run import Folder, record_all, run
from lagrangian_ff.studies.study import Request

CLEAN = next(case.name for case in cases(small=True) if case.group == "clean")


@dataclass
class Guess:
    """Says the same of every arm."""

    effect: str
    refuses: bool = False

    def identify(self, motion: Motion) -> None:
        assert len(motion.joints) == 6

    def diagnose(self, model: None, motion: Motion, confirm: Motion) -> Answer:
        if self.refuses:
            raise RecordingError("too short")
        return Answer([finding(self.effect, "joint_2")], {"verdict": ""})

    def add(self, model: None, effect: str, joint: str, shape: Any = None) -> None:
        raise AssertionError("nothing is added twice")

    def errors(self, model: None, motion: Motion) -> Mapping[str, float]:
        return dict.fromkeys(motion.joints, 1.0)


def short_study(folder: Path, guess: Guess) -> NuisancesStudy:
    request = Request(quick=True, only=CLEAN, keep=True)
    return NuisancesStudy(request, folder, examined=guess, longest=7.0)


def examined(folder: Path, guess: Guess) -> dict[str, Any]:
    study = short_study(folder, guess)
    (line,) = run(study, folder)
    study.results([line]).table()
    Folder(folder, study.name).lines.unlink()
    return line


def test_a_name_is_wrong_unless_it_is_that_of_a_nuisance(tmp_path: Path) -> None:
    made = record_all(short_study(tmp_path, Guess("ripple")), tmp_path)
    assert made == [f"recorded: 1 of 1 cases, in {tmp_path}"]
    kept = tmp_path / "recordings" / CLEAN / "1.npz"
    before = kept.stat().st_mtime_ns
    wrong = examined(tmp_path, Guess("ripple"))
    assert kept.stat().st_mtime_ns == before
    assert wrong["judgement"] == {
        "outcome": "wrong", "false": ["ripple on joint_2"], "suggested": [],
    }  # fmt: skip
    assert wrong["refused"] is None
    nuisances = wrong["plant"]["nuisances"]
    right = examined(tmp_path, Guess("torque_gain"))
    assert bool(right["judgement"]["false"]) == (set(nuisances["gains"]) == {1.0})
    refused = examined(tmp_path, Guess("ripple", refuses=True))
    assert refused["judgement"]["outcome"] == "nothing"
    assert refused["refused"] == "too short"
    assert refused["plant"] == wrong["plant"]


def test_it_lists_its_cases_and_takes_one_base_model(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = str(tmp_path / "study")
    assert main(["study", "nuisances", "--output", folder, "--list", "--quick"]) == 0
    assert capsys.readouterr().out.split() == [case.name for case in cases(small=True)]
    with pytest.raises(UserError, match="one base model"):
        NuisancesStudy(Request(models=("auto", "vrbfs")), tmp_path)


def test_a_study_without_recordings_makes_none(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["study", "ideal", "--record", "--output", str(tmp_path / "study")]) == 2
    assert "study ideal has no --record" in capsys.readouterr().err
