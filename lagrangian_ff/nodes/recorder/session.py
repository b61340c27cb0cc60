"""The recordings of a session, the model they gave, and the results of the jobs about it."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

from lagrangian_ff.nodes.common.status import Status


@dataclass(frozen=True)
class SavedModel:
    """A model on disk.

    Attributes:
        file: of the model.
        values: its name and its errors, as the status shows them.
    """

    file: Path
    values: Mapping[str, object]


@dataclass(frozen=True)
class Result:
    """The result of a job, made in its process.

    Its fields are plain values, so that the node takes it without importing what made it.

    Attributes:
        log: lines.
        statuses: by name.
        model: the model that the job made; None for none.
        report: the file of the JSON that it wrote; empty for none.
        bags: recordings that the session is to have besides its own, and their joints.
    """

    log: tuple[str, ...]
    statuses: Mapping[str, Status] = field(default_factory=dict)
    model: SavedModel | None = None
    report: str = ""
    bags: tuple[str, ...] = ()
    joints: tuple[str, ...] = ()


@dataclass
class Session:
    """The state between the services of the recorder.

    Attributes:
        bags: finished recordings, in the order in which they were made or loaded.
        joints: of the recordings that were loaded.
        current: the bag being recorded.
        busy: the present job in one word, such as "identifying"; empty without one.
        model: the last model, identified or extended.
        results: of the last jobs about this model, by service.
        failures: why the last job failed, by service.
    """

    bags: list[Path] = field(default_factory=list)
    joints: tuple[str, ...] = ()
    current: Path | None = None
    busy: str = ""
    model: SavedModel | None = None
    results: dict[str, Result] = field(default_factory=dict)
    failures: dict[str, str] = field(default_factory=dict)

    @property
    def state(self) -> str:
        """Return what the recorder does now, in one word."""
        return "recording" if self.current else self.busy or "idle"

    def refusal(self, service: str) -> str:
        """Return why this service is impossible now and what to do first, or ""."""
        recording = f"recording to {self.current}: call ~/stop first"
        if service == "stop":
            return "" if self.current else "not recording: call ~/start first"
        if service in ("start", "clear"):
            return recording if self.current else ""
        if self.busy:
            return f"{self.busy}: wait for the end (see /diagnostics), or call ~/clear to cancel"
        if service == "save" and self.model is None:
            failure = self.failures.get("identify", "")
            reason = f"the last identification failed: {failure}; " if failure else ""
            return f"{reason}no model yet: call ~/identify first and wait for its end"
        return ""

    def take(self, service: str, result: Result) -> None:
        """Take the result of a job; with a new model the results about the old one are dropped."""
        if result.model is not None:
            self.model = result.model
            self.results.clear()
        self.bags += map(Path, result.bags)
        self.joints = tuple(dict.fromkeys((*self.joints, *result.joints)))
        self.results[service] = result


def new_path(directory: Path, stem: str, suffix: str = "") -> Path:
    """Return a path in the directory that does not exist yet: stem, stem_2, stem_3 and so on."""
    number, path = 1, directory / f"{stem}{suffix}"
    while path.exists():
        number += 1
        path = directory / f"{stem}_{number}{suffix}"
    return path
