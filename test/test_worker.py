"""A job in its process: the protocol, and every way in which it can end."""

import sys
import time
from dataclasses import dataclass, field
from pathlib import Path

import pytest

from lagrangian_ff.nodes.recorder.jobs.identify import Identify
from lagrangian_ff.nodes.recorder.session import Result
from lagrangian_ff.progress import Progress
from lagrangian_ff.worker import Outcome, Worker, say

JOB = Identify(output="model.npz", bags=("nowhere",), joints=("a",), effort_scale={"a": 2.0})


def finished(worker: Worker) -> Outcome:
    deadline = time.monotonic() + 120.0
    while time.monotonic() < deadline:
        outcome = worker.outcome()
        if outcome is not None:
            return outcome
        time.sleep(0.01)
    raise AssertionError("the process does not end")


def program(text: str) -> tuple[str, ...]:
    return (sys.executable, "-c", text)


def test_progress_and_result_come_back() -> None:
    text = """
import json, pickle, sys
from lagrangian_ff.nodes.recorder.session import Result
job = pickle.loads(bytes.fromhex(sys.argv[1]))
print("a library that prints")
print(3)
print(json.dumps({"progress": 0.25, "label": "reading"}))
result = Result((job.service, str(job.effort_scale["a"])))
print(json.dumps({"result": pickle.dumps(result).hex()}))
"""
    worker = Worker(JOB, program(text))
    assert finished(worker) == Outcome(Result(("identify", "2.0")))
    assert (worker.fraction, worker.label) == (0.25, "reading")


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("""print('{"error": "too short"}')""", "too short"),
        ("""print('{"result": "2e"}')""", "cannot be read"),
        ("import sys; sys.exit(7)", "ended without a result (exit code 7)"),
        ("import os; os.abort()", "ended without a result"),
    ],
)
def test_every_end_without_a_result_is_an_error_in_words(text: str, expected: str) -> None:
    outcome = finished(Worker(JOB, program(text)))
    assert outcome.result is None
    assert expected in outcome.error


@dataclass
class Echo:
    """Says twice what it is told, until that is `end`."""

    heard: list[str] = field(default_factory=list)

    def hear(self, text: str) -> None:
        self.heard.append(text)

    def work(self, progress: Progress) -> int:
        while "end" not in self.heard:
            say([2 * text for text in self.heard])
            time.sleep(0.01)
        return len(self.heard)


def test_a_job_hears_and_says(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PYTHONPATH", str(Path(__file__).parent))
    worker = Worker(Echo())
    worker.tell("a")
    worker.tell("b")
    deadline = time.monotonic() + 60.0
    while worker.said != ["aa", "bb"]:
        assert time.monotonic() < deadline
        time.sleep(0.01)
    worker.tell("end")
    assert finished(worker) == Outcome(3)
    worker.tell("too late")


def test_it_can_be_cancelled() -> None:
    worker = Worker(JOB, program("import time; time.sleep(600)"))
    assert worker.outcome() is None
    worker.cancel()
    assert finished(worker).result is None


def test_the_process_does_the_job_of_the_request() -> None:
    outcome = finished(Worker(JOB))
    assert outcome.result is None
    assert "nowhere: no such file" in outcome.error
