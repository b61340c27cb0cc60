"""The services that the recorder allows, and what it answers to the others."""

from pathlib import Path

import pytest

from lagrangian_ff.nodes.recorder.jobs import JOBS
from lagrangian_ff.nodes.recorder.session import Result, SavedModel, Session, new_path

BAG, MODEL = Path("bag"), SavedModel(Path("model.npz"), {})
IDLE = Session()
RECORDED = Session(bags=[BAG])
RECORDING = Session(current=BAG)
BUSY = Session(bags=[BAG], busy="diagnosing")
BOTH = Session(bags=[BAG], current=Path("next"), busy="identifying")
IDENTIFIED = Session(bags=[BAG], model=MODEL)
FAILED = Session(bags=[BAG], failures={"identify": "too short"})
WORK = {"load", "identify", "compare", "diagnose", "add", "investigate"}


@pytest.mark.parametrize(
    ("session", "state", "allowed"),
    [
        (IDLE, "idle", {"start", "clear", "load", "add", "investigate"}),
        (RECORDED, "idle", {"start", "clear", *WORK}),
        (RECORDING, "recording", {"stop", "load", "add", "investigate"}),
        (BUSY, "diagnosing", {"start", "clear"}),
        (BOTH, "recording", {"stop"}),
        (IDENTIFIED, "idle", {"start", "save", "clear", *WORK}),
        (FAILED, "idle", {"start", "clear", *WORK}),
    ],
)
def test_each_state_allows_these(session: Session, state: str, allowed: set[str]) -> None:
    refusals = {name: session.refusal(name) for name in ("start", "stop", "save", "clear")}
    refusals |= {job.service: job.refusal(session) for job in JOBS}
    assert {service for service, refusal in refusals.items() if not refusal} == allowed
    assert all("~/" in refusal for refusal in refusals.values() if refusal), "it says what to do"
    assert session.state == state
    assert {job.service for job in JOBS} == WORK


def test_a_refusal_says_why_there_is_no_model() -> None:
    assert "the last identification failed: too short" in FAILED.refusal("save")


def test_findings_are_dropped_with_the_model_they_are_about() -> None:
    session = Session(bags=[BAG], model=MODEL)
    session.take("compare", Result(("0.1 N·m",)))
    assert (session.model, list(session.results)) == (MODEL, ["compare"])
    new = SavedModel(Path("new.npz"), {"model": "m"})
    session.take("add", Result(("added",), model=new))
    assert (session.model, list(session.results)) == (new, ["add"])


def test_names_are_never_taken_twice(tmp_path: Path) -> None:
    names = []
    for _ in range(3):
        path = new_path(tmp_path, "run", ".npz")
        path.touch()
        names.append(path.name)
    assert names == ["run.npz", "run_2.npz", "run_3.npz"]
