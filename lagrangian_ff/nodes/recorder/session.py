"""What may be done when: recordings are made, a model is learned, held against them, enlarged."""

from dataclasses import dataclass, field
from datetime import datetime
from enum import Enum
from pathlib import Path
from typing import Any

from lagrangian_ff.nodes.recorder.order import Addition, Order, Task
from lagrangian_ff.record_json import why_of


class State(Enum):
    """What the recorder is busy with."""

    IDLE = "idle"
    RECORDING = "recording"
    IDENTIFYING = "identifying"
    COMPARING = "comparing"
    DIAGNOSING = "diagnosing"
    ADDING = "adding"


BUSY = {
    Task.IDENTIFY: State.IDENTIFYING,
    Task.COMPARE: State.COMPARING,
    Task.DIAGNOSE: State.DIAGNOSING,
    Task.ADD: State.ADDING,
}
"""The state while a task is carried out."""

CONFIRMED = "confirmed"


@dataclass(frozen=True)
class Result:
    """A model: its file and the record of how it was made."""

    model: Path
    record: dict[str, Any]


@dataclass
class Session:
    """The recordings, the model they gave, and what was found out about it.

    Attributes:
        state: what is going on.
        bags: finished recordings, in the order in which they were made.
        current: the bag being recorded.
        result: the last model, identified or enlarged.
        found: the last comparison, diagnosis and addition of this model.
        failures: why the last piece of work of a kind came to nothing.
    """

    state: State = State.IDLE
    bags: list[Path] = field(default_factory=list)
    current: Path | None = None
    result: Result | None = None
    found: dict[Task, dict[str, Any]] = field(default_factory=dict)
    failures: dict[Task, str] = field(default_factory=dict)

    def refusal(self, action: str) -> str:
        """Why this action (the name of a service) is impossible now, and what to do; empty where
        it is possible."""
        if action == "stop" and self.state is State.RECORDING:
            return ""
        if action == "clear" and self.state is not State.RECORDING:
            return ""
        if self.state is State.RECORDING:
            return f"recording to {self.current}: call ~/stop first"
        if self.state is not State.IDLE:
            return (
                f"{self.state.value}: wait for the end (see /diagnostics), or call ~/clear to "
                "cancel"
            )
        if action == "stop":
            return "not recording: call ~/start first"
        if action in ("identify", "compare", "diagnose") and not self.bags:
            return "nothing recorded: call ~/start, move the arm, call ~/stop"
        if action == "save" and self.result is None:
            failure = self.failures.get(Task.IDENTIFY, "")
            reason = f"the last identification failed: {failure}; " if failure else ""
            return f"{reason}no model yet: call ~/identify first and wait for its end"
        return ""

    def finish(self, order: Order, record: dict[str, Any] | None, error: str) -> None:
        """Take what an order gave. What was found out about an older model is dropped."""
        task = order.task
        self.state = State.IDLE
        self.failures.pop(task, None)
        if record is None:
            self.failures[task] = error
        elif task is Task.IDENTIFY:
            self.result = Result(Path(order.output), record)
            self.found.clear()
        elif task is Task.ADD:
            self.result = Result(Path(order.output), record["record"])
            self.found = {task: record}
        else:
            self.found[task] = record

    def confirmed(self) -> tuple[Addition, ...]:
        """What the last diagnosis confirmed, with the reasons for the model's history.

        A load or a contact, which has no `why`, is of the recording and not to be added.
        """
        findings = self.found.get(Task.DIAGNOSE, {}).get("findings", [])
        return tuple(
            _addition(one) for one in findings if one["verdict"] == CONFIRMED and one["why"]
        )


def _addition(finding: dict[str, Any]) -> Addition:
    return Addition(finding["effect"], finding["joints"][0], finding["shape"], why_of(finding))


def new_path(directory: Path, stem: str, suffix: str = "") -> Path:
    """A path in the directory that does not exist yet: stem, stem_2, stem_3 and so on."""
    number, path = 1, directory / f"{stem}{suffix}"
    while path.exists():
        number += 1
        path = directory / f"{stem}_{number}{suffix}"
    return path


def stamped(prefix: str, now: datetime) -> str:
    """The name of a recording begun now."""
    return f"{prefix}_{now:%Y%m%d_%H%M%S}"
