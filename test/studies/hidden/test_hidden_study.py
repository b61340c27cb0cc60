"""`study hidden`: its machinery with a diagnosis that always says the same, and with our own."""

import json
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from diagnosis_examples import finding

from lagrangian_ff.cli.main import main
from lagrangian_ff.diagnosis.thresholds import Effort, using
from lagrangian_ff.errors import ModelError, UserError
from lagrangian_ff.recording.motion import Motion
from lagrangian_ff.studies.hidden.cases import Hidden, HiddenCase, cases
from lagrangian_ff.studies.hidden.plants import Stretches
from lagrangian_ff.studies.hidden.results import HiddenResults
from lagrangian_ff.studies.hidden.study import Answer, Examination, HiddenStudy, OwnDiagnosis
from lagrangian_ff.studies.run import Folder, run
from lagrangian_ff.studies.study import Request

SHORT = Stretches(((6, 4.0),))
LONGER = Stretches(((2, 6.0), (6, 12.0)))


@dataclass
class Guess:
    """Says the same of every arm; its model is the list of the effects that were added."""

    effect: str = "ripple"
    joint: str = "joint_2"
    broken: bool = False

    def identify(self, motion: Motion) -> list[tuple[str, str]]:
        assert motion.joints[0] == "joint_1"
        return []

    def diagnose(self, model: list[tuple[str, str]], motion: Motion, confirm: Motion) -> Answer:
        assert motion.tau.shape != (0, 6)
        assert not np.array_equal(motion.q[:100], confirm.q[:100])
        if self.broken:
            raise ModelError("cannot")
        return Answer([finding(self.effect, self.joint)], {"verdict": ""})

    def add(
        self,
        model: list[tuple[str, str]],
        effect: str,
        joint: str,
        shape: Mapping[str, float] | None = None,
    ) -> list[tuple[str, str]]:
        return [*model, (effect, joint)]

    def errors(self, model: list[tuple[str, str]], motion: Motion) -> Mapping[str, float]:
        return {joint: 2.0 - 0.5 * len(model) for joint in motion.joints}


def study(folder: Path, guess: Guess, only: str, **asked: Any) -> HiddenStudy:
    request = Request(quick=True, only=only, **asked)
    return HiddenStudy(request, folder, examined=guess, stretches=SHORT)


def examined(folder: Path, guess: Guess, only: str, **asked: Any) -> list[dict[str, Any]]:
    return run(study(folder, guess, only, **asked), folder)


def test_the_study_judges_keeps_and_resumes(tmp_path: Path) -> None:
    seen: list[float] = []
    (ripple,) = run(
        study(tmp_path, Guess(), "ripple-joint_2-20", keep=True),
        tmp_path,
        progress=lambda share, _: seen.append(share),
    )
    assert seen == [0.0, 1.0]
    assert ripple["judgement"]["outcome"] == "right"
    assert ripple["ratio"] == 1.0
    assert set(ripple["seconds"]) == {"recording", "identification", "diagnosis", "adding"}
    lines = examined(tmp_path, Guess(), "[rp]i*-joint_2-20", keep=True)
    assert [line["case"] for line in lines] == ["ripple-joint_2-20", "pitting-joint_2-20"]
    assert lines[0] == ripple
    assert lines[1]["judgement"]["outcome"] == "wrong"
    assert lines[1]["ratio"] is None
    kept = tmp_path / "recordings" / "ripple-joint_2-20"
    assert {file.name for file in kept.iterdir()} == {"1.npz", "2.npz", "info.json"}
    # The recordings that are kept are those that are judged again.
    Folder(tmp_path, "hidden").lines.unlink()
    (again,) = examined(tmp_path, Guess("stribeck"), "ripple-joint_2-20", keep=True)
    assert again["judgement"]["outcome"] == "wrong"
    assert again["plant"] == ripple["plant"]
    assert HiddenResults.of([*lines, again]).record()["cases"] == 3


def test_what_happens_once_is_named_and_not_added(tmp_path: Path) -> None:
    case = HiddenCase("x", (Hidden("payload", "joint_2", 0.2),), 0, 3)
    load = Examination(case, tmp_path, SHORT, Guess("payload")).run()
    assert load["judgement"]["outcome"] == "right"
    assert set(load["errors"]) == {"base"}
    assert load["ratio"] is None


def test_a_case_that_breaks_down_is_tried_again_but_not_on_another_model(tmp_path: Path) -> None:
    (line,) = examined(tmp_path, Guess(broken=True), "clean-00", keep=True)
    assert line["failed"] == "ModelError: cannot"
    results = HiddenResults.of([line])
    assert results.failed == {"clean-00": "ModelError: cannot"}
    assert any("cannot" in text for text in results.table())
    (line,) = examined(tmp_path, Guess(), "clean-00", keep=True)
    assert line["judgement"]["outcome"] == "wrong"
    with pytest.raises(UserError, match=r"another study .*vrbfs\+fri.* expected .*auto\+fri"):
        examined(tmp_path, Guess(), "clean-00", keep=True, models=("auto+fri",))
    with pytest.raises(UserError, match="one base model"):
        study(tmp_path, Guess(), "*", models=("auto", "vrbfs"))


class Silent:
    """A diagnosis that never finds anything."""

    def identify(self, motion: Any) -> None:
        """Know nothing."""

    def diagnose(self, model: None, motion: Any, confirm: Any) -> Answer:
        return Answer([], {"verdict": "at the noise floor", "findings": []})

    def add(self, model: None, effect: str, joint: str, shape: Any = None) -> None:
        """Learn nothing."""

    def errors(self, model: None, motion: Any) -> dict[str, float]:
        return dict.fromkeys(motion.joints, 1.0)


def test_it_lists_the_cases_without_doing_them(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = str(tmp_path / "study")
    assert main(["study", "hidden", "--output", folder, "--list", "--small"]) == 0
    assert capsys.readouterr().out.split() == [case.name for case in cases(small=True)]
    assert not (tmp_path / "study").exists()


def test_silence_about_a_clean_arm_is_right(tmp_path: Path) -> None:
    request = Request(quick=True, only="clean-00")
    study = HiddenStudy(request, tmp_path, examined=Silent(), stretches=SHORT)
    results = study.results(run(study, tmp_path))
    assert "nothing hidden: 0 of 1 with a confirmed effect" in "\n".join(results.table())
    assert (results.record()["cases"], results.record()["clean"]["wrong"]) == (1, 0)


def test_a_study_leaves_lines_numbers_and_a_picture(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = tmp_path / "study"
    command = ["study", "ideal", "--output", str(folder), "--quick", "--cases", "n1-robot00-rbf"]
    assert main([*command, "--json", str(tmp_path / "found.json")]) == 0
    assert "each the mean over 1 robot" in capsys.readouterr().out
    assert {"cases.jsonl", "summary.json", "ideal.png", "study.json"} <= {
        path.name for path in folder.iterdir()
    }
    numbers = json.loads((folder / "summary.json").read_text())
    assert numbers == json.loads((tmp_path / "found.json").read_text())
    assert numbers["models"]["rbf"]["1"]["count"] == 1
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
def test_mistakes_are_reported_in_one_line(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], options: list[str], message: str
) -> None:
    assert main(["study", "hidden", "--output", str(tmp_path / "study"), *options]) == 2
    error = capsys.readouterr().err
    assert message in error
    assert error.count("\n") == 1


@pytest.fixture
def few_rows() -> Iterator[None]:
    with using(effort=Effort(rows=2100)):
        yield


@pytest.mark.usefixtures("few_rows")
def test_a_ripple_is_named_and_a_clean_arm_is_left_alone(tmp_path: Path) -> None:
    clean, ripple = (
        run(
            HiddenStudy(
                Request(quick=True, only=name),
                tmp_path,
                examined=OwnDiagnosis("chain+fri", steps=1),
                stretches=LONGER,
            ),
            tmp_path,
        )[0]
        for name in ("clean-00", "ripple-joint_2-20")
    )
    assert clean["judgement"] == {"outcome": "nothing", "false": [], "suggested": []}
    assert ripple["judgement"]["outcome"] == "right"
    (found,) = ripple["record"]["findings"]
    order = ripple["plant"]["hidden"][0]["facts"]["times a turn"]
    assert found["shape"]["order"] == order
    assert ripple["ratio"] < 1.1
    assert ripple["errors"]["found"]["joint_2"] < ripple["errors"]["base"]["joint_2"]
