"""Work in a process of its own: the order, the protocol, and an identification by it."""

import re
import sys
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from lagrangian_ff.errors import UserError
from lagrangian_ff.identification import Model
from lagrangian_ff.nodes.common.summary import lines
from lagrangian_ff.nodes.recorder.job import Job, Outcome
from lagrangian_ff.nodes.recorder.order import Addition, Order, Task
from lagrangian_ff.nodes.recorder.tasks.identifying import identify_bags
from lagrangian_ff.recording import Recording, write_bag

ORDER = Order(
    Task.IDENTIFY, "model.npz", bags=("bag",), joints=("a",), effort_scale={"a": 2.0},
    prismatic=("a",), landmarks=0,
    additions=(Addition("stribeck", "a", {"v_s": 0.1}, {"verdict": "confirmed"}),),
)  # fmt: skip


def finished(job: Job) -> Outcome:
    deadline = time.monotonic() + 30.0
    while time.monotonic() < deadline:
        outcome = job.outcome()
        if outcome is not None:
            return outcome
        time.sleep(0.01)
    raise AssertionError("the job does not end")


def program(text: str) -> tuple[str, ...]:
    return (sys.executable, "-c", text)


def test_an_order_survives_the_way() -> None:
    assert Order.from_json(ORDER.to_json()) == ORDER


def test_progress_and_result_come_back() -> None:
    text = """
import json, sys
order = json.loads(sys.argv[1])
print("a library that prints")
print(3)
print(json.dumps({"progress": 0.25, "label": "reading"}))
print(json.dumps({"result": {"scale": order["effort_scale"]}}))
"""
    job = Job(ORDER, program(text))
    assert finished(job) == Outcome({"scale": {"a": 2.0}})
    assert (job.fraction, job.label) == (0.25, "reading")


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("""print('{"error": "too short"}')""", "too short"),
        ("import sys; sys.exit(7)", "ended without a result (exit code 7)"),
        ("import os; os.abort()", "ended without a result"),
    ],
)
def test_every_end_without_a_result_is_an_error_in_words(text: str, expected: str) -> None:
    outcome = finished(Job(ORDER, program(text)))
    assert outcome.record is None
    assert expected in outcome.error


def test_it_can_be_cancelled() -> None:
    job = Job(ORDER, program("import time; time.sleep(600)"))
    assert job.outcome() is None
    job.cancel()
    assert finished(job).record is None


@pytest.fixture(scope="module")
def bag(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """20 s of two joints whose effort is half the torque."""
    time = np.arange(0.0, 20.0, 0.01)
    phase = time[:, None] * np.array([2.1, 3.3])
    q, qd, qdd = 0.6 * np.sin(phase), 0.6 * np.cos(phase), -0.6 * np.sin(phase)
    qd, qdd = qd * [2.1, 3.3], qdd * np.square([2.1, 3.3])
    tau = 6.0 * np.cos(q) + 1.2 * qdd + 0.5 * qd
    path: Path = tmp_path_factory.mktemp("job") / "bag"
    return write_bag(path, Recording(("a", "b"), time, q, qd, 0.5 * tau, start=1.7e9))


def test_from_bags_to_a_model_in_newton_metres(bag: Path, tmp_path: Path) -> None:
    told: list[float] = []
    order = Order(
        Task.IDENTIFY, str(tmp_path / "model.npz"), bags=(str(bag),), samples=60, train=0.6,
        effort_scale={"a": 2.0, "b": 2.0},
    )  # fmt: skip
    record = identify_bags(order, lambda fraction, label: told.append(fraction))
    model = Model.load(tmp_path / "model.npz")
    still = np.zeros((1, 2))
    np.testing.assert_allclose(model.predict(still, still, still), 6.0, rtol=0.05)
    assert told == sorted(told)
    assert re.match(r"identified chain\w*\+fri from 60 samples", lines(record)[0])
    assert len(lines(record)) == 3


def test_what_cannot_be_identified_is_a_mistake_in_words(bag: Path, tmp_path: Path) -> None:
    order = Order(Task.IDENTIFY, str(tmp_path / "model.npz"), bags=(str(bag),))
    for change, expected in (
        ({"joints": ("c",)}, "no joint c"),
        ({"model": "nonsense"}, "nonsense"),
        ({"prismatic": ("c",)}, "prismatic names c"),
        ({"landmarks": -2}, "landmarks is -2"),
        ({"positive": True, "model": "rbf"}, "kept positive"),
        ({"bags": (str(tmp_path / "missing"),)}, "no such file"),
    ):
        with pytest.raises(UserError, match=expected):
            identify_bags(replace(order, **change), lambda fraction, label: None)
    assert not (tmp_path / "model.npz").exists()
