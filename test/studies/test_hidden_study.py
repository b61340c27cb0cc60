"""The study's machinery on short recordings, with a diagnosis that knows only two effects."""

import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from matplotlib.patches import Rectangle

from lagrangian_ff.arm import check_limits
from lagrangian_ff.errors import ModelError, UserError
from lagrangian_ff.recording.motion import Motion
from lagrangian_ff.studies.common.folder import Folder
from lagrangian_ff.studies.common.run import run
from lagrangian_ff.studies.common.study import Request
from lagrangian_ff.studies.hidden import plants
from lagrangian_ff.studies.hidden.cases import Case, Hidden
from lagrangian_ff.studies.hidden.examine import examine
from lagrangian_ff.studies.hidden.figure import figure
from lagrangian_ff.studies.hidden.plants import Stretches
from lagrangian_ff.studies.hidden.study import HiddenStudy
from lagrangian_ff.studies.hidden.table import summary, table

SHORT = Stretches(((6, 4.0),))


@dataclass
class Guess:
    """Says the same of every arm; its model is the list of the effects that were added."""

    effect: str = "ripple"
    joint: str = "joint_2"
    broken: bool = False

    def identify(self, motion: Motion) -> list[tuple[str, str]]:
        assert motion.joints[0] == "joint_1"
        return []

    def diagnose(
        self, model: list[tuple[str, str]], motion: Motion, confirm: Motion
    ) -> Mapping[str, Any]:
        assert motion.tau.shape != (0, 6)
        assert not np.array_equal(motion.q[:100], confirm.q[:100])
        if self.broken:
            raise ModelError("cannot")
        claim = {"effect": self.effect, "joints": [self.joint], "verdict": "confirmed"}
        return {"verdict": "", "findings": [{**claim, "ambiguous_with": []}]}

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


@pytest.fixture(scope="module")
def motions(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder where runs of the arm without effects are kept."""
    return tmp_path_factory.mktemp("motions")


def test_a_case_becomes_two_recordings_of_one_plant(motions: Path) -> None:
    case = Case("x", (Hidden("ripple", "joint_2", 0.2), Hidden("delay", "joint_5", 0.05)), 0, 3)
    first, second, plant = plants.record(case, motions, SHORT)
    assert len(first) == len(second) == 2001
    assert not np.array_equal(first.position, second.position)
    ripple, delay = plant["hidden"]
    assert ripple["reached"][0] == pytest.approx(0.2, rel=0.2)
    assert delay["reached"][0] == pytest.approx(0.05, rel=0.3)
    assert 0.0 < ripple["visible"][0] <= ripple["reached"][0] + 1e-9
    assert (ripple["catalogue"], ripple["joints"]) == (["ripple"], ["joint_2"])
    json.dumps(plant)
    again = plants.record(case, motions, SHORT)
    np.testing.assert_array_equal(again[0].effort, first.effort)
    assert again[2] == plant


def test_both_recordings_are_of_one_arm(motions: Path) -> None:
    case = Case("x", (Hidden("saturation", "joint_2", 0.2),), 0, 3)
    first, second, plant = plants.record(case, motions, SHORT)
    limit = plant["hidden"][0]["facts"]["limit [N·m]"]
    noise = 160.0 * 0.0385 * 0.12
    for recording in (first, second):
        assert limit < np.abs(recording.effort[:, 1]).max() < limit + 6.0 * noise


def test_motions_are_joined_at_rest_within_the_limits() -> None:
    whole = plants.motion(0, 1, Stretches(((2, 4.0), (6, 4.0))))
    assert whole.duration == pytest.approx(8.0)
    check_limits(whole)
    np.testing.assert_allclose(whole.sample(4.0)[1], 0.0, atol=1e-9)
    slow, fast = (np.abs(whole.qd[part]).mean() for part in (slice(0, 400), slice(400, 800)))
    assert fast > 1.5 * slow


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
    numbers = summary([*lines, again])
    assert numbers["cases"] == 3


def test_what_happens_once_is_named_and_not_added(motions: Path) -> None:
    case = Case("x", (Hidden("payload", "joint_2", 0.2),), 0, 3)
    load = examine(case, motions, SHORT, Guess("payload"))
    assert load["judgement"]["outcome"] == "right"
    assert set(load["errors"]) == {"base"}
    assert load["ratio"] is None


def test_a_case_that_breaks_down_is_tried_again_but_not_on_another_model(tmp_path: Path) -> None:
    (line,) = examined(tmp_path, Guess(broken=True), "clean-00", keep=True)
    assert line["failed"] == "ModelError: cannot"
    numbers = summary([line])
    assert numbers["failed"] == {"clean-00": "ModelError: cannot"}
    assert any("cannot" in text for text in table(numbers))
    (line,) = examined(tmp_path, Guess(), "clean-00", keep=True)
    assert line["judgement"]["outcome"] == "wrong"
    with pytest.raises(UserError, match=r"another study .*vrbfs\+fri.* expected .*auto\+fri"):
        examined(tmp_path, Guess(), "clean-00", keep=True, models=("auto+fri",))
    with pytest.raises(UserError, match="one base model"):
        study(tmp_path, Guess(), "*", models=("auto", "vrbfs"))


def line(
    group: str, size: float = 0.1, outcome: str = "right", *, effect: str = "ripple",
    ratio: float | None = 1.0, absorbed: bool = False, count: int = 1,
) -> list[dict[str, Any]]:  # fmt: skip
    hidden = {
        "effect": effect,
        "size": size,
        "absorbed": absorbed,
        "visible": [0.6 * size] * 2,
        "reached": [size] * 2,
        "catalogue": [effect],
        "joints": ["joint_2"],
    }
    cannot = {"effect": "stribeck", "joint": "joint_2"}
    false = ["stribeck on joint_1"] if outcome == "wrong" else []
    return [
        {
            "case": f"{group}-{effect}-{size}-{outcome}-{k}",
            "group": group,
            "plant": {"hidden": [] if group == "clean" else [hidden]},
            "judgement": {"outcome": outcome, "false": false, "suggested": []},
            "record": {"not_observable": [cannot]},
            "ratio": ratio,
        }
        for k in range(count)
    ]


LINES = [
    *line("alone", count=6),
    *line("alone", outcome="class", count=2),
    *line("alone", outcome="wrong", ratio=3.0),
    *line("alone", outcome="nothing", ratio=2.0, effect="stribeck"),
    *line("alone", size=0.02, outcome="nothing", ratio=1.3),
    *line("alone", outcome="nothing", effect="spring", absorbed=True),
    *line("pair", outcome="part"),
    *line("clean", outcome="nothing", count=19),
    *line("clean", outcome="wrong"),
    *line("outside", outcome="nothing", effect="pitting", ratio=None),
]


def test_the_summary_counts_what_was_judged() -> None:
    numbers = summary(LINES)
    row = numbers["sizes"]["0.1"]
    assert (row["cases"], row["right"], row["class"], row["wrong"], row["nothing"]) == (
        10, 6, 2, 1, 1,
    )  # fmt: skip
    assert numbers["visible"]["0.05-0.1"] == row
    # Stribeck friction was missed and said not to be observable, the ripple of 2 % only missed.
    assert (row["told"], numbers["sizes"]["0.02"]["told"]) == (1, 0)
    assert numbers["absorbed"]["0.1"]["nothing"] == 1
    assert numbers["pairs"]["0.1"]["part"] == 1
    assert (numbers["clean"]["cases"], numbers["clean"]["wrong"]) == (20, 1)
    assert 0.05 < numbers["clean"]["high"] < 0.3
    assert numbers["outside"]["wrong"] == 0
    assert numbers["ratio"]["0.1"]["median"] == 1.0
    assert numbers["ratio"]["0.1"]["within_1.1"] == pytest.approx(0.8)
    assert numbers["effects"]["stribeck"]["0.1"]["nothing"] == 1
    json.dumps(numbers)
    text = "\n".join(table(numbers))
    assert "0.60" in text
    assert "nothing hidden: 1 of 20" in text
    assert "one that some models hold already, so that nothing is right too, by size:" in text


def test_what_no_strength_makes_large_counts_under_what_it_reached() -> None:
    weak = line("alone", size=0.1, outcome="nothing")
    weak[0]["plant"]["hidden"][0]["reached"] = [0.048, 0.06]
    numbers = summary([*line("alone", size=0.1), *weak])
    assert numbers["sizes"]["0.1"]["nothing"] == 0
    assert numbers["sizes"]["0.05"]["nothing"] == 1


def test_the_figure_holds_what_the_summary_says() -> None:
    numbers = summary(LINES)
    drawn = figure(numbers)
    bars, ratios, effects = drawn.axes
    assert [t.get_text() for t in bars.get_xticklabels()][:2] == ["2 %", "10 %"]
    boxes = [patch for patch in bars.patches if isinstance(patch, Rectangle)]
    tall = [box.get_height() for box in boxes if box.get_x() + 0.5 * box.get_width() == 1.0]
    assert tall[0] == pytest.approx(0.6)
    assert sum(tall) == pytest.approx(1.0)
    shown = [len(np.asarray(points.get_xdata())) for points in ratios.lines]
    assert [count for count in shown if count != 2] == [1, 10]
    assert [t.get_text() for t in effects.get_yticklabels()] == ["stribeck", "ripple", "spring"]


def test_a_study_without_results_draws_and_prints() -> None:
    numbers = summary([])
    assert table(numbers) == ["0 cases"]
    figure(numbers)
