"""What the recorder allows when, and what it says where it does not."""

from datetime import datetime
from pathlib import Path

import pytest

from lagrangian_ff.nodes.recorder.session import Result, Session, State, new_path, stamped

BAG, MODEL = Path("bag"), Result(Path("model.npz"), {})
IDLE = Session()
RECORDED = Session(bags=[BAG])
RECORDING = Session(State.RECORDING, current=BAG)
IDENTIFYING = Session(State.IDENTIFYING, [BAG])
IDENTIFIED = Session(bags=[BAG], result=MODEL)
FAILED = Session(bags=[BAG], failure="too short")


@pytest.mark.parametrize(
    ("session", "allowed"),
    [
        (IDLE, {"start", "clear"}),
        (RECORDED, {"start", "identify", "clear"}),
        (RECORDING, {"stop"}),
        (IDENTIFYING, {"clear"}),
        (IDENTIFIED, {"start", "identify", "save", "clear"}),
        (FAILED, {"start", "identify", "clear"}),
    ],
)
def test_each_state_allows_these(session: Session, allowed: set[str]) -> None:
    actions = {"start", "stop", "identify", "save", "clear"}
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
