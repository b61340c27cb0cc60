"""The statuses and log lines of the results, and what of them another job needs."""

from typing import Any

import pytest
from diagnosis_examples import diagnosis, doubt, fault, finding, run, taken_up

from lagrangian_ff.diagnosis.results import Unexplained
from lagrangian_ff.effects import EFFECTS
from lagrangian_ff.identification.history import Step
from lagrangian_ff.identification.records import Identified
from lagrangian_ff.nodes.common.status import Level, Status
from lagrangian_ff.nodes.recorder.jobs.add import Add
from lagrangian_ff.nodes.recorder.jobs.compare import Compare
from lagrangian_ff.nodes.recorder.jobs.diagnose import Addition, Diagnose, Diagnosed
from lagrangian_ff.nodes.recorder.jobs.identify import Identify
from lagrangian_ff.nodes.recorder.session import Session


def result(**change: Any) -> Diagnosed:
    """Return what the node takes of a diagnosis; checks or other fields may be given."""
    checks = change.pop("checks", ())
    found = run(diagnosis(**change), checks=checks)
    return Diagnose(output="d.json").result(found, {"page": "d.html"})


def diagnosed(**change: Any) -> dict[str, Status]:
    session = Session()
    session.take("diagnose", result(**change))
    return Diagnose.statuses(session)


def added(before: float, after: float) -> Status:
    step = Step("stribeck on a", "", before, after, judged_on="the rest")
    session = Session(results={"diagnose": result()})
    job = Add(output="new.npz", additions=(Addition("stribeck", "a"),))
    session.take("add", job.result(Identified(model="m"), [step], {"page": "new.html"}))
    assert session.model is not None
    assert session.model.values["model"] == "m"
    assert not Diagnose.statuses(session), "it was about the old model"
    return Add.statuses(session)["addition"]


@pytest.mark.parametrize(
    ("verdict", "level", "change"),
    [
        ("confirmed", Level.WARN, {}),
        ("ambiguous with drift", Level.WARN, {"rivals": ("drift",)}),
        ("suggested", Level.OK, {"doubt": doubt("why not")}),
    ],
)
def test_a_finding_warns_where_something_is_surely_missing(
    verdict: str, level: Level, change: dict[str, Any]
) -> None:
    status = diagnosed(findings=(finding(**change),))["stribeck on elbow"]
    assert status.level is level
    assert status.values["verdict"] == verdict
    assert status.values["F_s"] == "1.25 N·m (1 to 1.5)"
    assert status.values["next motion"] == EFFECTS["stribeck"].next_motion
    assert status.values.get("not confirmed because") == ("why not" if "doubt" in change else None)
    assert ("1.5 to 0.9 N·m" in status.message) == (verdict == "confirmed")


def test_a_finding_not_tested_against_chance_has_no_p_value() -> None:
    values = diagnosed(taken_up=taken_up())["payload on shoulder, elbow"].values
    assert "p value" not in values
    assert values["evidence gain [nats]"] == 300.0


def test_an_unexplained_dependence_is_a_warning() -> None:
    statuses = diagnosed(unexplained=(Unexplained("elbow", "position", 0.1, 50.0),))
    assert statuses["unexplained on elbow: position"].level is Level.WARN
    assert statuses["diagnosis"].level is Level.WARN


def test_a_fault_of_the_measurement_comes_before_the_verdict() -> None:
    assert diagnosed()["diagnosis"].level is Level.OK
    calm = fault(serious=False, finding="fine")
    status = diagnosed(checks=(fault(), calm))["diagnosis"]
    assert status.level is Level.WARN
    assert status.message.startswith("fix first: elbow: saturation; no effect")
    whole = str(status.values["verdict"])
    assert whole.startswith("Fix first: elbow: clipped at 1.2 N·m. Leave")
    assert "fine" not in whole


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
    logged = result(findings=(finding(),)).log
    assert logged[0].startswith("Missing and confirmed: stribeck on elbow")
    assert any("stribeck on elbow: confirmed" in line for line in logged)
    assert "  page: d.html" in logged


def test_a_failure_does_not_hide_the_findings_before_it() -> None:
    session = Session(failures={"diagnose": "too short"})
    session.take("diagnose", result(findings=(finding(),)))
    statuses = Diagnose.statuses(session)
    assert statuses["diagnosis"].level is Level.ERROR
    assert statuses["stribeck on elbow"].level is Level.WARN


def test_what_is_confirmed_of_the_arm_is_to_be_added() -> None:
    others = (finding("ripple", doubt=doubt()), finding("spring", rivals=("offset",)))
    assert not result(findings=others, taken_up=taken_up()).confirmed
    (added,) = result(findings=(*others, finding())).confirmed
    assert (added.effect, added.joint, added.shape) == ("stribeck", "elbow", {"v_s": 0.1})
    why = dict(added.why)
    assert "213 nats" in str(why.pop("why"))
    assert why == {"verdict": "confirmed", "evidence_gain": 213.0, "p_value": 0.01}
