"""The study of measured recordings: its cases, table, verdicts and what it refuses."""

import json
from pathlib import Path
from typing import Any

import pytest
from measured_examples import write, write_known

from lagrangian_ff.cli.main import main
from lagrangian_ff.errors import UserError
from lagrangian_ff.studies.measured.alone import alone, peak_memory
from lagrangian_ff.studies.measured.known import Expected, Known
from lagrangian_ff.studies.measured.results import judge
from lagrangian_ff.studies.measured.study import MeasuredStudy
from lagrangian_ff.studies.study import Request


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    write(tmp_path / "arm" / "one.csv") if write_known(tmp_path / "arm") else None
    write(tmp_path / "arm" / "two.csv", seed=1)
    return tmp_path


def test_the_table_stands_beside_the_standard_way(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    output = folder / "study"
    command = ["study", "measured", str(folder), "--output", str(output), "--jobs", "1", "--quick"]
    assert main(command) == 0
    said = capsys.readouterr().out
    assert "arm, 1-2:" in said
    assert (output / "measured.png").stat().st_size > 1000
    errors = json.loads((output / "summary.json").read_text())["uses"]["arm, 1-2"]["errors"]
    assert set(errors) == {"standard", "auto+fri", "auto+fri@kinematics"}
    assert errors["standard"]["ratio"] == pytest.approx(1.0)
    for one in errors.values():
        assert max(one["nmse"]) < 0.02
        assert 0.01 < one["memory"] < 4.0
        assert one["seconds"] >= 0.0
    lines = (output / "cases.jsonl").read_bytes()
    assert main([*command, "--only", "arm"]) == 0  # nothing is left to do
    assert (output / "cases.jsonl").read_bytes() == lines


def test_without_kinematics_there_is_no_standard_way(folder: Path) -> None:
    write_known(folder / "arm", kinematics=None)
    study = MeasuredStudy(Request(recordings=folder, models=("motor+fri",)), folder)
    assert [case.name for case in study.cases()] == ["arm/1-2/motor+fri"]


def test_what_is_right_may_change_and_how_recordings_are_used_may_not(folder: Path) -> None:
    def study() -> MeasuredStudy:
        return MeasuredStudy(Request(recordings=folder), folder)

    before = study()
    done = {"arm": "arm", "used": before.arms[0].used}
    write_known(folder / "arm", may=[{"effects": ["stribeck"]}], about="another word")
    assert study().identity() == before.identity()
    assert study().current(done)
    write_known(folder / "arm", splits={"2-1": {"train": ["two"], "test": ["one"]}})
    assert not study().current(done)


def line(*findings: dict[str, Any], contacts: list[tuple[float, float]] | None = None) -> Any:
    whole = [{"ambiguous_with": [], "joints": ["elbow"], **one} for one in findings]
    record = {"findings": whole, "unexplained": [{"joint": "elbow", "coordinate": "load"}]}
    return {"record": record, "contacts": contacts or [], "cpu": {"diagnose": 1.0}, "memory": 0.1}


def arm(may: tuple[Expected, ...] = (), must: tuple[Expected, ...] = ()) -> Known:
    return Known("arm", "", ("shoulder", "elbow"), {}, (), may=may, must=must)


def test_findings_are_judged_by_what_is_known() -> None:
    stribeck = {"effect": "stribeck", "verdict": "confirmed"}
    drift = {"effect": "drift", "verdict": "suggested"}
    either = {"effect": "drift", "verdict": "ambiguous", "ambiguous_with": ["stribeck"]}
    on_elbow = arm(may=(Expected(("stribeck",), ("elbow",)),))
    found = judge(on_elbow, line(stribeck, drift))
    assert (found.right, found.wrong) == (("stribeck on elbow",), ())
    assert found.suggested == ("drift on elbow",)
    assert found.unexplained == ("elbow over load",)
    assert judge(on_elbow, line(either)).right == ("drift or stribeck on elbow",)
    elsewhere = arm(must=(Expected(("stribeck",), ("shoulder",)),))
    found = judge(elsewhere, line(stribeck))
    assert found.wrong == ("stribeck on elbow",)
    assert found.missing == ("stribeck",)


@pytest.mark.parametrize(("begin", "sure"), [(2.1, True), (2.1, False), (6.0, True)])
def test_a_touch_is_judged_as_a_contact_is(begin: float, sure: bool) -> None:
    given = line(contacts=[(2.0, 2.4)])
    given["record"]["contacts"] = [
        {"begin": begin, "end": begin + 0.2, "sizes": {"elbow": {}}, "sure": sure}
    ]
    found = judge(arm(must=(Expected(("contact",)),)), given)
    words = ("contact on elbow",)
    assert found.right == (words if sure and begin < 3.0 else ())
    assert found.wrong == (words if begin > 3.0 else ())
    assert found.suggested == (() if sure else words)


@pytest.mark.parametrize("field", ["parameters", "shape"])
@pytest.mark.parametrize(
    ("since", "length", "right"), [(2.1, 0.6, True), (6, 0.6, False), (2, 5, False)]
)
def test_a_contact_is_right_at_its_time(
    field: str, since: float, length: float, right: bool
) -> None:
    contact: dict[str, Any] = {"effect": "contact", "verdict": "confirmed", "parameters": {}}
    contact["shape"] = {"t0": since, "length": length}
    if field == "parameters":
        contact["parameters"] = {name: {"value": v} for name, v in contact["shape"].items()}
        contact["shape"] = {}
    known = arm(must=(Expected(("contact",)),))
    found = judge(known, line(contact, contacts=[(2.0, 2.5)]))
    assert bool(found.right) == right
    assert bool(found.wrong) != right
    assert bool(found.missing) != right


def test_what_the_study_refuses(folder: Path) -> None:
    with pytest.raises(UserError, match="needs the folder of the recordings"):
        MeasuredStudy(Request(), folder)
    assert main(["study", "ideal", str(folder), "--list"]) == 2
    assert main(["study", "measured", str(folder), "--robots", "3", "--list"]) == 2


def test_a_process_of_its_own_returns_raises_and_may_die() -> None:
    assert 0.005 < alone(peak_memory) < peak_memory() + 0.5
    with pytest.raises(ZeroDivisionError):
        alone(divmod, 1, 0)
    with pytest.raises(RuntimeError, match="ended with 3"):
        alone(exit, 3)
