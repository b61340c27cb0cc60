"""What records become on /diagnostics where nothing is to be computed for it."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest

from lagrangian_ff.nodes.common.status import Level
from lagrangian_ff.nodes.recorder.findings import finding_statuses, lines, work_status
from lagrangian_ff.nodes.recorder.order import Order, Task
from lagrangian_ff.nodes.recorder.session import Session, State

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


def diagnosed(**change: Any) -> Session:
    session = Session()
    session.finish(Order(Task.DIAGNOSE, "d.json"), {**DIAGNOSIS, **change}, "")
    return session


def added(before: float, after: float) -> Session:
    step = {"added": "stribeck on a", "error_before": before, "error_after": after,
            "judged_on": "the rest"}  # fmt: skip
    session = Session()
    record = {"record": {}, "steps": [step], "added": ["stribeck on a"]}
    session.finish(Order(Task.ADD, "new.npz"), record, "")
    return session


@pytest.mark.parametrize(
    ("verdict", "level"),
    [
        ("confirmed", Level.WARN),
        ("ambiguous with drift", Level.WARN),
        ("suggested", Level.OK),
    ],
)
def test_a_finding_warns_where_something_is_surely_missing(verdict: str, level: Level) -> None:
    one = {**FINDING, "verdict": verdict, "reason": "why not"}
    status = finding_statuses(diagnosed(findings=[one]))["stribeck on a"]
    assert status.level is level
    assert status.values["F_s"] == "1 N·m (0.9 to 1.1)"
    assert status.values["next motion"] == "creep"
    assert ("0.5 to 0.2 N·m" in status.message) == (verdict == "confirmed")


def test_what_was_not_held_against_chance_has_no_p_value() -> None:
    one = {**FINDING, "effect": "payload", "p_value": None}
    values = finding_statuses(diagnosed(findings=[one]))["payload on a"].values
    assert "p value" not in values
    assert values["evidence gain [nats]"] == 80.0


def test_what_nobody_can_name_is_told() -> None:
    rest = {"joint": "b", "coordinate": "position", "share": 0.1, "evidence_gain": 50.0}
    session = diagnosed(unexplained=[rest])
    statuses = finding_statuses(session)
    assert statuses["unexplained on b: position"].level is Level.WARN
    assert work_status(Task.DIAGNOSE, session, None)["diagnosis"].level is Level.WARN


def test_a_fault_of_the_measurement_comes_before_the_verdict() -> None:
    assert work_status(Task.DIAGNOSE, diagnosed(), None)["diagnosis"].level is Level.OK
    check = {"check": "sign", "joint": "a", "finding": "the torque has the wrong sign",
             "advice": "turn it over", "serious": True}  # fmt: skip
    calm = {**check, "serious": False, "finding": "fine"}
    status = work_status(Task.DIAGNOSE, diagnosed(preflight=[check, calm]), None)["diagnosis"]
    assert status.level is Level.WARN
    assert status.message.startswith("Fix first: a: the torque has the wrong sign")
    assert "fine" not in status.message


def test_an_addition_that_does_not_help_says_why_it_may_be() -> None:
    better = work_status(Task.ADD, added(2.0, 1.0), None)["addition"]
    worse = work_status(Task.ADD, added(2.0, 2.1), None)["addition"]
    assert (better.level, worse.level) == (Level.OK, Level.WARN)
    assert "identify again" in worse.message
    assert "identify again" not in better.message


def test_a_failure_is_an_error_of_its_own_kind() -> None:
    session = Session()
    session.finish(Order(Task.COMPARE, "c.json"), None, "no such joint")
    status = work_status(Task.COMPARE, session, None)["comparison"]
    assert (status.level, status.message) == (Level.ERROR, "comparison failed: no such joint")
    assert work_status(Task.DIAGNOSE, session, None) == {}
    assert work_status(Task.IDENTIFY, session, None)["identification"].level is Level.OK


@dataclass(frozen=True)
class Working:
    order: Order
    fraction: float = 0.5
    label: str = "looking"


def test_progress_is_told_under_the_name_of_the_work() -> None:
    session = Session(State.DIAGNOSING, [Path("bag")])
    job = Working(Order(Task.DIAGNOSE, "d.json"))
    status = work_status(Task.DIAGNOSE, session, job)["diagnosis"]
    assert status.message == "diagnosing: looking"
    assert status.values["progress"] == 0.5
    assert work_status(Task.IDENTIFY, session, job)["identification"].message == "no model yet"


def test_the_log_names_findings_and_files() -> None:
    told = lines(Order(Task.DIAGNOSE, "d.json"), {**DIAGNOSIS, "findings": [FINDING]})
    assert told[0] == "Nothing is missing."
    assert any("stribeck on a: confirmed" in line for line in told)
    assert "  page: d.html" in told
