"""The statuses and log lines that records become."""

from typing import Any

import pytest

from lagrangian_ff.nodes.common.status import Level, Status
from lagrangian_ff.nodes.recorder.jobs.add import Add
from lagrangian_ff.nodes.recorder.jobs.compare import Compare
from lagrangian_ff.nodes.recorder.jobs.diagnose import Diagnose
from lagrangian_ff.nodes.recorder.jobs.identify import Identify
from lagrangian_ff.nodes.recorder.session import Session

FINDING: dict[str, Any] = {
    "effect": "stribeck", "joints": ["a"], "verdict": "confirmed", "reason": "",
    "evidence_gain": 80.0, "p_value": 0.01, "error_before": 0.5, "error_after": 0.2,
    "parameters": {"F_s": {"value": 1.0, "low": 0.9, "high": 1.1, "unit": "N·m"}},
    "shape": {"v_s": 0.1}, "meaning": "friction", "told_apart_by": [], "next_motion": "creep",
}  # fmt: skip
DIAGNOSIS: dict[str, Any] = {
    "model": "m.npz", "sources": ["one"], "confirm": ["two"], "confirmed_on": "two",
    "verdict": "Nothing is missing.", "findings": [], "unexplained": [], "not_observable": [],
    "preflight": [], "json": "d.json", "page": "d.html",
}  # fmt: skip


def diagnosed(**change: Any) -> dict[str, Status]:
    session = Session()
    Diagnose(output="d.json").end(session, {**DIAGNOSIS, **change})
    return Diagnose.statuses(session)


def added(before: float, after: float) -> Status:
    step = {"added": "stribeck on a", "error_before": before, "error_after": after,
            "judged_on": "the rest"}  # fmt: skip
    session = Session(found={"diagnose": DIAGNOSIS})
    record = {"record": {"model": "m"}, "steps": [step], "added": ["stribeck on a"]}
    Add(output="new.npz").end(session, record)
    assert session.model is not None
    assert session.model.record == {"model": "m"}
    assert not Diagnose.statuses(session), "it was about the old model"
    return Add.statuses(session)["addition"]


@pytest.mark.parametrize(
    ("verdict", "level"),
    [("confirmed", Level.WARN), ("ambiguous with drift", Level.WARN), ("suggested", Level.OK)],
)
def test_a_finding_warns_where_something_is_surely_missing(verdict: str, level: Level) -> None:
    one = {**FINDING, "verdict": verdict, "reason": "why not"}
    status = diagnosed(findings=[one])["stribeck on a"]
    assert status.level is level
    assert status.values["F_s"] == "1 N·m (0.9 to 1.1)"
    assert status.values["next motion"] == "creep"
    assert ("0.5 to 0.2 N·m" in status.message) == (verdict == "confirmed")


def test_a_finding_not_tested_against_chance_has_no_p_value() -> None:
    one = {**FINDING, "effect": "payload", "p_value": None}
    values = diagnosed(findings=[one])["payload on a"].values
    assert "p value" not in values
    assert values["evidence gain [nats]"] == 80.0


def test_an_unexplained_dependence_is_a_warning() -> None:
    rest = {"joint": "b", "coordinate": "position", "share": 0.1, "evidence_gain": 50.0}
    statuses = diagnosed(unexplained=[rest])
    assert statuses["unexplained on b: position"].level is Level.WARN
    assert statuses["diagnosis"].level is Level.WARN


def test_a_fault_of_the_measurement_comes_before_the_verdict() -> None:
    assert diagnosed()["diagnosis"].level is Level.OK
    check = {"check": "sign", "joint": "a", "finding": "the torque has the wrong sign",
             "advice": "turn it over", "serious": True}  # fmt: skip
    calm = {**check, "serious": False, "finding": "fine"}
    status = diagnosed(preflight=[check, calm])["diagnosis"]
    assert status.level is Level.WARN
    assert status.message.startswith("Fix first: a: the torque has the wrong sign")
    assert "fine" not in status.message


def test_an_addition_that_does_not_help_says_why() -> None:
    better = added(2.0, 1.0)
    worse = added(2.0, 2.1)
    assert (better.level, worse.level) == (Level.OK, Level.WARN)
    assert "identify again" in worse.message
    assert "identify again" not in better.message


def test_a_failure_is_an_error_of_its_job_alone() -> None:
    session = Session(failures={"compare": "no such joint"})
    status = Compare.statuses(session)["comparison"]
    assert (status.level, status.message) == (Level.ERROR, "comparison failed: no such joint")
    assert Diagnose.statuses(session) == {}
    status = Identify.statuses(session)["identification"]
    assert (status.level, status.message) == (Level.OK, "no model yet")


def test_the_log_names_findings_and_files() -> None:
    logged = Diagnose(output="d.json").log({**DIAGNOSIS, "findings": [FINDING]})
    assert logged[0] == "Nothing is missing."
    assert any("stribeck on a: confirmed" in line for line in logged)
    assert "  page: d.html" in logged
