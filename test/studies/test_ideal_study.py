"""`lagrangian_ff study ideal`: Fig. 2 at a small size, from the command line."""

import json
from pathlib import Path

import pytest

from lagrangian_ff.cli.main import main
from lagrangian_ff.studies.ideal import IdealStudy
from lagrangian_ff.studies.study import Request


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
