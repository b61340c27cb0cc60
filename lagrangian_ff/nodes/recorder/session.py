"""What may be done when: recordings are made, then identified, then the model is kept."""

from dataclasses import dataclass, field
from datetime import datetime
from enum import Enum
from pathlib import Path
from typing import Any


class State(Enum):
    """What the recorder is busy with."""

    IDLE = "idle"
    RECORDING = "recording"
    IDENTIFYING = "identifying"


@dataclass(frozen=True)
class Result:
    """An identified model: its file and the record of how it was made."""

    model: Path
    record: dict[str, Any]


@dataclass
class Session:
    """The recordings to identify from, and the model they gave.

    Attributes:
        state: what is going on.
        bags: finished recordings, used together.
        current: the bag being recorded.
        result: the last identified model.
        failure: why the last identification gave none.
    """

    state: State = State.IDLE
    bags: list[Path] = field(default_factory=list)
    current: Path | None = None
    result: Result | None = None
    failure: str = ""

    def refusal(self, action: str) -> str:
        """Why this action (start, stop, identify, save, clear) is impossible now, and what to
        do; empty where it is possible."""
        busy = {
            State.RECORDING: f"recording to {self.current}: call ~/stop first",
            State.IDENTIFYING: "identifying: wait for the end (see /diagnostics), or call "
            "~/clear to cancel",
        }
        if action == "stop":
            if self.state is State.RECORDING:
                return ""
            return busy.get(self.state, "not recording: call ~/start first")
        if action == "clear":
            return busy[self.state] if self.state is State.RECORDING else ""
        if self.state is not State.IDLE:
            return busy[self.state]
        if action == "identify" and not self.bags:
            return "nothing recorded: call ~/start, move the arm, call ~/stop"
        if action == "save" and self.result is None:
            reason = f"the last identification failed: {self.failure}; " if self.failure else ""
            return f"{reason}no model yet: call ~/identify first and wait for its end"
        return ""


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
