"""The recordings of a session, the model they gave, and what was found out about it."""

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any


@dataclass(frozen=True)
class SavedModel:
    """A model on disk, with the record of how it was made."""

    file: Path
    record: dict[str, Any]


@dataclass
class Session:
    """The state between the services of the recorder.

    Attributes:
        bags: finished recordings, in the order in which they were made.
        current: the bag being recorded.
        busy: the present job in one word, such as "identifying"; empty without one.
        model: the last model, identified or extended.
        found: the record of the last job about this model, by service.
        failures: why the last job failed, by service.
    """

    bags: list[Path] = field(default_factory=list)
    current: Path | None = None
    busy: str = ""
    model: SavedModel | None = None
    found: dict[str, dict[str, Any]] = field(default_factory=dict)
    failures: dict[str, str] = field(default_factory=dict)

    @property
    def state(self) -> str:
        """Return what the recorder does now, in one word."""
        return "recording" if self.current else self.busy or "idle"

    def refusal(self, service: str) -> str:
        """Return why this service is impossible now and what to do first, or ""."""
        if self.current is not None:
            return "" if service == "stop" else f"recording to {self.current}: call ~/stop first"
        if service == "clear":
            return ""
        if self.busy:
            return f"{self.busy}: wait for the end (see /diagnostics), or call ~/clear to cancel"
        if service == "stop":
            return "not recording: call ~/start first"
        if service == "save" and self.model is None:
            failure = self.failures.get("identify", "")
            reason = f"the last identification failed: {failure}; " if failure else ""
            return f"{reason}no model yet: call ~/identify first and wait for its end"
        return ""

    def take_model(self, file: Path, record: dict[str, Any]) -> None:
        """Take a new model; what was found out about the old one is dropped."""
        self.model = SavedModel(file, record)
        self.found.clear()


def new_path(directory: Path, stem: str, suffix: str = "") -> Path:
    """Return a path in the directory that does not exist yet: stem, stem_2, stem_3 and so on."""
    number, path = 1, directory / f"{stem}{suffix}"
    while path.exists():
        number += 1
        path = directory / f"{stem}_{number}{suffix}"
    return path
