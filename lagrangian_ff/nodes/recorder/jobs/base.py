"""A job with recordings or a model: the base class of the services that take their time.

The node makes a request from the present situation, a process does the work, and the node takes
its record. So a job is imported by both: the imports that only the work needs stand in `work`.
"""

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, TypeVar

from lagrangian_ff.errors import UserError
from lagrangian_ff.files import whole
from lagrangian_ff.nodes.common.status import Level, Status
from lagrangian_ff.nodes.recorder.session import Session
from lagrangian_ff.progress import Progress
from lagrangian_ff.record_json import to_json

if TYPE_CHECKING:
    from lagrangian_ff.identification import Model
    from lagrangian_ff.recording import Conditioning, Motion

J = TypeVar("J", bound="Job")


@dataclass(frozen=True)
class Situation:
    """The state of the node from which a request is made.

    Attributes:
        session: the recordings and the model.
        value: returns the value of a parameter.
        topic: of the joint states.
        joints: those with parameters for their effort.
        description: the URDF that came on robot_description; empty if none did.
    """

    session: Session
    value: Callable[[str], Any]
    topic: str
    joints: Sequence[str] = ()
    description: str = ""

    @property
    def directory(self) -> Path:
        """Return where bags, models and findings are written."""
        return absolute(self.value("output_directory"))

    @property
    def saved_model(self) -> Path:
        """Return where ~/save puts the model."""
        wanted = self.value("model_file")
        return absolute(wanted) if wanted else self.directory / "model.npz"

    @property
    def present_model(self) -> Path:
        """Return the last model of the session, else the one that `model_file` names.

        Raises:
            UserError: there is neither.
        """
        if self.session.model is not None:
            return self.session.model.file
        if not self.value("model_file"):
            raise UserError(
                "no model: call ~/identify first, or name the file of one with the parameter "
                "model_file"
            )
        if not self.saved_model.is_file():
            raise UserError(
                f"no model: the parameter model_file names {self.saved_model}, which does not "
                "exist; call ~/identify first, or name a model that exists"
            )
        return self.saved_model

    @property
    def common(self) -> dict[str, Any]:
        """Return the fields of a request that every job has."""
        return {
            "topic": self.topic,
            "effects_file": optional(self.value("effects_file")),
            "effort_scale": {joint: self.value(f"effort_scale.{joint}") for joint in self.joints},
            "effort_offset": {joint: self.value(f"effort_offset.{joint}") for joint in self.joints},
        }


@dataclass(frozen=True, kw_only=True)
class Job(ABC):
    """A request as its fields, and everything that becomes of it.

    Attributes:
        service: name of the service.
        doing: what the node says while the job runs.
        title: name of its status.
        needs_recordings: whether it is refused before something was recorded.
        output: the file to write, a model or findings as JSON; a page of the same name with the
            ending .html comes beside it.
        bags: recordings used together.
        topic: of the joint states in them.
        model_file: the model that the job is about; empty for none.
        effects_file: Python that defines effects of the user's own; empty for none.
        effort_scale, effort_offset: by joint, N·m per unit of effort and N·m.
    """

    service: ClassVar[str]
    doing: ClassVar[str]
    title: ClassVar[str]
    needs_recordings: ClassVar[bool] = True

    output: str
    bags: tuple[str, ...] = ()
    topic: str = "joint_states"
    model_file: str = ""
    effects_file: str = ""
    effort_scale: Mapping[str, float] = field(default_factory=dict)
    effort_offset: Mapping[str, float] = field(default_factory=dict)

    @classmethod
    def refusal(cls, session: Session) -> str:
        """Return why the job is impossible now and what to do first, or ""."""
        nothing = "nothing recorded: call ~/start, move the arm, call ~/stop"
        missing = nothing if cls.needs_recordings and not session.bags else ""
        return session.refusal(cls.service) or missing

    @classmethod
    @abstractmethod
    def request(cls: type[J], given: Situation) -> J:
        """Return the request for what is to be done now.

        Raises:
            UserError: something is missing, such as a model.
        """

    @abstractmethod
    def summary(self) -> str:
        """Return what has begun, in words."""

    @abstractmethod
    def work(self, progress: Progress) -> dict[str, Any]:
        """Do the job in its process and return the record that `end` and `status` take.

        Args:
            progress: receives the share done, 0 to 1, and what is done now.

        Raises:
            UserError: a recording, the model or a setting cannot be used.
        """

    def end(self, session: Session, record: dict[str, Any]) -> None:
        """Take the record of the work into the session."""
        session.found[self.service] = record

    @classmethod
    @abstractmethod
    def status(cls, record: Mapping[str, Any]) -> Status:
        """Return the status of a record."""

    @classmethod
    def statuses(cls, session: Session) -> dict[str, Status]:
        """Return the statuses by name while the job does not run; empty if it never ran."""
        if cls.service in session.failures:
            failure = f"{cls.title} failed: {session.failures[cls.service]}"
            return {cls.title: Status(Level.ERROR, failure)}
        if cls.service in session.found:
            return {cls.title: cls.status(session.found[cls.service])}
        return {}

    def log(self, record: Mapping[str, Any]) -> list[str]:
        """Return the lines to log at the end."""
        files = [f"  {label}: {file}" for label, file in files_of(record).items()]
        return [self.status(record).message, *self.details(record), *files]

    def details(self, record: Mapping[str, Any]) -> list[str]:
        """Return further lines to log."""
        return []

    def open_model(self) -> "Model":
        """Return the model, with the user's own effects that it may have."""
        from lagrangian_ff.identification import Model
        from lagrangian_ff.nodes.common.models import load_own_effects

        load_own_effects(self.effects_file)
        return Model.load(self.model_file)

    def read(
        self, bags: Sequence[str], joints: Sequence[str], conditioning: "Conditioning",
        progress: Progress,
    ) -> "list[Motion]":  # fmt: skip
        """Return the motions of these joints, of all joints if none is named."""
        from lagrangian_ff.recording import condition, load

        motions = []
        for number, bag in enumerate(bags):
            progress(number / len(bags), f"reading {Path(bag).name}")
            recording = load(bag, topic=self.topic, joints=joints or None)
            motions.append(condition(recording, conditioning))
        return motions

    def read_for(self, model: "Model", bags: Sequence[str], progress: Progress) -> "list[Motion]":
        """Return motions, conditioned as those the model was identified from."""
        from lagrangian_ff.nodes.common.models import conditioning_for

        conditioning = conditioning_for(model, self.effort_scale, self.effort_offset)
        return self.read(bags, model.joints, conditioning, progress)


def absolute(text: str) -> Path:
    """Return an absolute path, ~ expanded."""
    return Path(text).expanduser().absolute()


def optional(text: str) -> str:
    """Return an absolute path as text, empty if it was not given."""
    return str(absolute(text)) if text else ""


def names_of(bags: Sequence[str]) -> str:
    """Return the names of bags, listed."""
    return ", ".join(Path(bag).name for bag in bags)


def write_json(path: Path, record: Mapping[str, Any]) -> None:
    """Write a record whole or not at all; numbers that are not finite become null.

    Raises:
        OSError: it cannot be written.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    with whole(path) as made:
        made.write_text(to_json(record), "utf-8")


def write_page(
    make: Callable[[Path, Mapping[str, Any]], Path], beside: Path, record: Mapping[str, Any]
) -> dict[str, str]:
    """Write the page beside a file and return its name, or why it failed: findings stand alone."""
    path = beside.with_suffix(".html")
    try:
        return {"page": str(make(path, record))}
    except (UserError, OSError) as error:
        return {"page": "", "page_failure": str(error)}


def files_of(record: Mapping[str, Any]) -> dict[str, object]:
    """Return the files that a record names, by label."""
    named = {"JSON": "json", "page": "page", "no page because": "page_failure"}
    return {label: record[name] for label, name in named.items() if record.get(name)}
