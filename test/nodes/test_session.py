"""What the recorder allows when, and what it says where it does not."""

from datetime import datetime
from pathlib import Path
from typing import Any

import pytest

from lagrangian_ff.nodes.recorder.order import Order, Task
from lagrangian_ff.nodes.recorder.session import Result, Session, State, new_path, stamped

BAG, MODEL = Path("bag"), Result(Path("model.npz"), {})
IDLE = Session()
RECORDED = Session(bags=[BAG])
RECORDING = Session(State.RECORDING, current=BAG)
BUSY = Session(State.DIAGNOSING, [BAG])
IDENTIFIED = Session(bags=[BAG], result=MODEL)
FAILED = Session(bags=[BAG], failures={Task.IDENTIFY: "too short"})
WORK = {"identify", "compare", "diagnose", "add"}


@pytest.mark.parametrize(
    ("session", "allowed"),
    [
        (IDLE, {"start", "clear", "add"}),
        (RECORDED, {"start", "clear", *WORK}),
        (RECORDING, {"stop"}),
        (BUSY, {"clear"}),
        (IDENTIFIED, {"start", "save", "clear", *WORK}),
        (FAILED, {"start", "clear", *WORK}),
    ],
)
def test_each_state_allows_these(session: Session, allowed: set[str]) -> None:
    actions = {"start", "stop", "save", "clear", *WORK}
    assert {action for action in actions if not session.refusal(action)} == allowed
    for action in actions - allowed:
        assert "~/" in session.refusal(action), "a refusal says what to do"


def test_a_refusal_tells_why_there_is_no_model() -> None:
    assert "the last identification failed: too short" in FAILED.refusal("save")


def test_names_are_never_taken_twice(tmp_path: Path) -> None:
    stem = stamped("run", datetime(2026, 1, 2, 3, 4, 5))
    assert stem == "run_20260102_030405"
    names = []
    for _ in range(3):
        path = new_path(tmp_path, stem, ".npz")
        path.touch()
        names.append(path.name)
    assert names == [f"{stem}.npz", f"{stem}_2.npz", f"{stem}_3.npz"]


def finding(effect: str, verdict: str) -> dict[str, Any]:
    return {
        "effect": effect, "joints": ["a"], "verdict": verdict, "shape": {"v_s": 0.1},
        "why": "it is felt", "evidence_gain": 40.0, "p_value": 0.01,
    }  # fmt: skip


def test_only_what_is_confirmed_is_added_without_asking() -> None:
    session = Session(bags=[BAG], result=MODEL)
    verdicts = {"stribeck": "confirmed", "drift": "suggested", "ripple": "ambiguous with drift"}
    findings = [finding(effect, verdict) for effect, verdict in verdicts.items()]
    findings.append({**finding("payload", "confirmed"), "why": "", "p_value": None})
    session.finish(Order(Task.DIAGNOSE, "d.json"), {"findings": findings}, "")
    (addition,) = session.confirmed()
    assert (addition.effect, addition.joint, addition.shape) == ("stribeck", "a", {"v_s": 0.1})
    assert addition.why["verdict"] == "confirmed"
    assert addition.why["why"] == "it is felt"


def test_findings_fall_with_the_model_they_are_about() -> None:
    session = Session(bags=[BAG], result=MODEL)
    session.finish(Order(Task.DIAGNOSE, "d.json"), {"findings": [finding("drag", "confirmed")]}, "")
    session.finish(Order(Task.COMPARE, "c.json"), None, "no such joint")
    assert session.confirmed()
    assert session.failures == {Task.COMPARE: "no such joint"}
    session.finish(Order(Task.ADD, "new.npz"), {"record": {"model": "m+drag@a"}}, "")
    assert session.result == Result(Path("new.npz"), {"model": "m+drag@a"})
    assert not session.confirmed()
    assert session.state is State.IDLE
