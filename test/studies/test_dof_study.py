"""Errors over the number of joints: lines, numbers and words; `study ideal` from end to end."""

import json
from pathlib import Path
from typing import Any

import pytest

from lagrangian_ff.cli.main import main
from lagrangian_ff.studies.dof import DofResults, IdealStudy, errors_of, order
from lagrangian_ff.studies.study import Request


def line(model: str, joints: int, robot: int, error: float, **more: Any) -> dict[str, Any]:
    case = f"n{joints}-robot{robot:02d}-{model}"
    return {"case": case, "model": model, "joints": joints, "robot": robot, "error": error,
            "gamma_raised": 1.0, **more}  # fmt: skip


LINES = [
    line("vrbfs", 2, 0, 0.1),
    line("vrbfs", 2, 1, 0.3, gamma_raised=10.0),
    line("rbfs", 2, 0, 0.2),
    line("rbfs", 2, 1, 0.6),
    line("rbfs", 2, 2, 0.01),
    line("vrbfs", 3, 0, 0.5),
    line("rbfs", 3, 0, 0.4),
    {"case": "n3-robot01-rbfs", "failed": "out of luck"},
]


def test_means_variances_and_medians_are_of_the_robots() -> None:
    numbers = DofResults.of(LINES, []).record()
    assert numbers["models"]["vrbfs"]["2"] == pytest.approx(
        {"mean": 0.2, "variance": 0.02, "median": 0.2, "count": 2, "gamma_raised": 10.0}
    )
    assert numbers["models"]["rbfs"]["2"]["median"] == 0.2
    assert numbers["models"]["rbfs"]["3"]["variance"] is None
    assert numbers["failed"] == {"n3-robot01-rbfs": "out of luck"}
    assert numbers["cases"] == 8


def test_models_are_compared_on_robots_that_both_learned() -> None:
    errors = errors_of(LINES)
    found = order(errors, ("vrbfs", "rbfs"), least_joints=2)
    assert found.claim == "vrbfs < rbfs"
    two, three = found.joints[2], found.joints[3]
    # Robot 2, which vrbfs has not learned, would turn it round.
    assert two.robots == 2
    assert two.means == pytest.approx({"vrbfs": 0.2, "rbfs": 0.4})
    assert two.holds
    assert not three.holds
    assert order(errors, ("vrbfs", "rbfs"), least_joints=3).joints.keys() == {3}
    assert order(errors, ("vrbfs", "chain")).joints == {}


def test_the_table_says_where_a_claim_holds_and_where_not() -> None:
    text = "\n".join(DofResults.of(LINES, [order(errors_of(LINES), ("vrbfs", "rbfs"))]).table())
    assert "NO   vrbfs < rbfs: at 2 joints; not at 3" in text
    assert "each the mean over 1 to 3 robots" in text
    assert "n3-robot01-rbfs: out of luck" in text


@pytest.mark.parametrize("lines", [LINES, LINES[:1], LINES[-1:]])
def test_there_is_a_picture_of_whatever_was_done(lines: list[dict[str, Any]]) -> None:
    results = DofResults.of(lines, [])
    axes = results.figure().axes
    assert len(axes) == 2
    drawn = {name for panel in axes for name in panel.get_legend_handles_labels()[1]}
    assert drawn == set(results.models)


def test_what_is_exact_does_not_squeeze_the_rest() -> None:
    results = DofResults.of([line("chain", 1, 0, 1e-15), line("chain", 2, 0, 1e-2)], [])
    assert results.figure().axes[0].get_ylim()[0] > 1e-9


def test_a_quick_study_bears_out_the_paper(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = tmp_path / "study"
    command = ["study", "ideal", "--quick", "--jobs", "1", "--output", str(folder)]
    assert main(command) == 0
    numbers = json.loads((folder / "summary.json").read_text())
    assert not numbers["failed"]
    findings = {claim: each["joints"] for claim, each in numbers["findings"].items()}
    assert set(findings) == {"vrbfs < srbfs < rbfs", "rbfs < rbf", "chain < vrbfs"}
    for claim, joints in findings.items():
        assert joints.keys() == {"2", "3"}
        assert all(row["holds"] and row["robots"] == 2 for row in joints.values()), claim
    assert "vrbfs < srbfs < rbfs: at 2, 3" in capsys.readouterr().out
    assert (folder / "ideal.png").read_bytes().startswith(b"\x89PNG")
    held = (folder / "cases.jsonl").read_bytes()
    lines = [json.loads(line) for line in held.splitlines()]
    # One and two joints: the kernel holds rigid bodies, and nothing but rounding is left.
    exact = [line for line in lines if line["model"] == "chain" and line["joints"] <= 2]
    assert len(exact) == 4
    assert all(line["error"] < 1e-8 * line["spread"] for line in exact)
    assert all(line["gamma"] == pytest.approx(1e-12) for line in lines)
    assert main(command) == 0
    assert (folder / "cases.jsonl").read_bytes() == held


def test_robots_come_one_after_the_other_with_all_models_and_joints(tmp_path: Path) -> None:
    cases = IdealStudy(Request(robots=3, models=("vrbfs", "motor")), tmp_path).every_case()
    assert [case.name for case in cases[:3]] == ["n1-robot00-vrbfs", "n1-robot00-motor",
                                                 "n2-robot00-vrbfs"]  # fmt: skip
    assert [case.robot for case in cases] == sorted(case.robot for case in cases)
    assert {case.joints for case in cases[:16]} == set(range(1, 9))
    more = IdealStudy(Request(robots=5), tmp_path).every_case()
    assert set(cases) < set(more)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--models", "vrbfs", "vrbfx"], "'vrbfx' is neither a kernel (auto, rbf, rbfs"),
        (["--models", "auto"], "expected one kernel (rbf, rbfs"),
        (["--robots", "0"], "--robots is 0"),
        (["--keep"], "study ideal has no --keep"),
    ],
)
def test_mistakes_are_reported_in_one_line(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], options: list[str], message: str
) -> None:
    assert main(["study", "ideal", "--output", str(tmp_path / "study"), *options]) == 2
    error = capsys.readouterr().err
    assert message in error
    assert error.count("\n") == 1
    assert not (tmp_path / "study").exists()
