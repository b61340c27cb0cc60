"""Compare, diagnose and add as the worker does them: findings, files, statuses.

The recording is short and the model small; that the search itself is right is tested where it is.
"""

import json
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from small_model import recorded_bag

from lagrangian_ff.effects import EFFECTS
from lagrangian_ff.errors import UserError
from lagrangian_ff.identification import Model
from lagrangian_ff.nodes.common.status import Level
from lagrangian_ff.nodes.recorder.findings import finding_statuses, lines, work_status
from lagrangian_ff.nodes.recorder.order import Addition, Order, Task
from lagrangian_ff.nodes.recorder.session import Session
from lagrangian_ff.nodes.recorder.tasks import comparing, diagnosing
from lagrangian_ff.nodes.recorder.work import program
from lagrangian_ff.progress import silent


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path: Path = tmp_path_factory.mktemp("tasks")
    clean = recorded_bag(path / "clean", drag=0.0)
    given = Order(Task.IDENTIFY, str(path / "model.npz"), bags=(str(clean),), samples=100)
    program(Task.IDENTIFY)(given, silent)
    recorded_bag(path / "bag", drag=0.9)
    return path


def done(order: Order) -> tuple[Session, dict[str, Any]]:
    """The session after the order, and what the worker told; progress rises."""
    told: list[float] = []
    record = program(order.task)(order, lambda fraction, label: told.append(fraction))
    assert told == sorted(told)
    session = Session()
    session.finish(order, json.loads(json.dumps(record)), "")
    return session, record


def order(folder: Path, task: Task, output: str, **more: Any) -> Order:
    return Order(
        task, str(folder / output), bags=(str(folder / "bag"),),
        model_file=str(folder / "model.npz"), **more,
    )  # fmt: skip


def test_compare_tells_where_and_writes_it_down(folder: Path) -> None:
    given = order(folder, Task.COMPARE, "where.json")
    session, record = done(given)
    written = json.loads((folder / "where.json").read_text())
    assert written["joints"]["b"]["rmse"] > 2.0 * written["joints"]["a"]["rmse"]
    assert "<html" in Path(record["page"]).read_text()
    status = work_status(Task.COMPARE, session, None)["comparison"]
    assert status.values["page"] == str(folder / "where.html")
    assert "where 1" in status.values
    assert lines(given, record)[0] == status.message


def test_diagnose_then_add_what_it_confirmed(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    few = {name: EFFECTS[name] for name in ("quadratic_drag", "spring", "drift")}
    quick = partial(diagnosing.diagnose, effects=few, steps=1)
    monkeypatch.setattr(diagnosing, "diagnose", quick)
    session, record = done(order(folder, Task.DIAGNOSE, "missing.json"))
    written = json.loads((folder / "missing.json").read_text())
    assert written["findings"][0]["effect"] == "quadratic_drag"
    assert {"check", "finding", "serious"} <= set(written["preflight"][0])
    assert "<html" in Path(record["page"]).read_text()
    statuses = finding_statuses(session)
    status = statuses["quadratic_drag on b"]
    assert status.level is Level.WARN
    assert status.values["verdict"] == "confirmed"
    assert {"evidence gain [nats]", "error before [N·m]", "error after [N·m]", "C",
            "next motion"} <= set(status.values)  # fmt: skip
    assert work_status(Task.DIAGNOSE, session, None)["diagnosis"].message == written["verdict"]

    given = order(folder, Task.ADD, "larger.npz", additions=session.confirmed())
    session, record = done(given)
    larger = Model.load(folder / "larger.npz")
    assert [step["added"] for step in larger.steps][-1] == "quadratic_drag on b"
    assert larger.steps[-1]["verdict"] == "confirmed"
    assert record["record"]["model"] == larger.name
    status = work_status(Task.ADD, session, None)["addition"]
    assert "added quadratic_drag on b" in status.message
    still = np.zeros((1, 2))
    moving = np.array([[0.0, 1.5]])
    assert not np.allclose(
        larger.predict(still, moving, still),
        Model.load(folder / "model.npz").predict(still, moving, still),
    )


def test_impossible_orders_are_mistakes_in_words(folder: Path) -> None:
    for given, expected in (
        (
            order(folder, Task.ADD, "x.npz", additions=(Addition("magic", "a"),)),
            "no effect 'magic'",
        ),
        (order(folder, Task.ADD, "x.npz", additions=(Addition("coulomb", "a"),)), "already"),
        (order(folder, Task.ADD, "x.npz", additions=(Addition("stribeck", "c"),)), "no joint 'c'"),
        (order(folder, Task.COMPARE, "x.json", topic="/other"), "/other"),
        (order(folder, Task.COMPARE, "x.json", effects_file="/nowhere.py"), "no such file"),
    ):
        with pytest.raises(UserError, match=expected):
            done(given)
    assert not list(folder.glob("x.*"))


def test_a_missing_page_does_not_hide_the_findings(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(*arguments: object) -> Path:
        raise UserError("plotly is not installed")

    monkeypatch.setattr(comparing, "compare_page", fail)
    session, _ = done(order(folder, Task.COMPARE, "plain.json"))
    assert (folder / "plain.json").exists()
    values = work_status(Task.COMPARE, session, None)["comparison"].values
    assert values["no page because"] == "plotly is not installed"
