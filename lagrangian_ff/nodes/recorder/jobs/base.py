"""A job with recordings or a model: the base class of the services that take their time.

The node makes a request from the present situation, a process does the work, and the node shows
its result. So a job is imported by both: the imports that only the work needs stand in `work`.
"""

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

from lagrangian_ff.errors import TopicError, UserError
from lagrangian_ff.files import whole
from lagrangian_ff.nodes.common.status import Level, Status
from lagrangian_ff.nodes.recorder.session import Result, Session
from lagrangian_ff.progress import Progress
from lagrangian_ff.record_json import to_json

if TYPE_CHECKING:
    from lagrangian_ff.identification import Model
    from lagrangian_ff.recording import Conditioning, Motion, Recording


@dataclass(frozen=True)
class Situation:
    """The state of the node from which a request is made.

    Attributes:
        session: the recordings and the model.
        value: returns the value of a parameter.
        topic: of the joint states.
        joints: those with parameters for their effort.
        description: the URDF that came on robot_description; empty if none did.
        node: full name of the node.
    """

    session: Session
    value: Callable[[str], Any]
    topic: str
    joints: Sequence[str] = ()
    description: str = ""
    node: str = "/identify"

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
    """A request as its fields, and the work that it asks for.

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
        effects_file: Python that defines the user's effects; empty for none.
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
        nothing = "nothing recorded: call ~/start, move the arm, call ~/stop; or ~/load"
        missing = nothing if cls.needs_recordings and not session.bags else ""
        return session.refusal(cls.service) or missing

    @classmethod
    @abstractmethod
    def request(cls, given: Situation) -> "Job":
        """Return the request for what is to be done now.

        Raises:
            UserError: something is missing, such as a model.
        """

    @abstractmethod
    def summary(self) -> str:
        """Return what has begun, in words."""

    @abstractmethod
    def work(self, progress: Progress) -> Result:
        """Do the job in its process and return what the node shows of it.

        Args:
            progress: receives the share done, 0 to 1, and what is done now.

        Raises:
            UserError: a recording, the model or a setting cannot be used.
        """

    @classmethod
    def statuses(cls, session: Session) -> dict[str, Status]:
        """Return the statuses by name while the job does not run; empty if it never ran."""
        result = session.results.get(cls.service)
        found = dict(result.statuses) if result else {}
        if failure := session.failures.get(cls.service):
            found[cls.title] = Status(Level.ERROR, f"{cls.title} failed: {failure}")
        return found

    def open_model(self) -> "Model":
        """Return the model; the user's effects are loaded first, since it may have some."""
        from lagrangian_ff.identification import Model
        from lagrangian_ff.nodes.common.models import load_own_effects

        load_own_effects(self.effects_file)
        return Model.load(self.model_file)

    def open_recording(self, bag: str, joints: Sequence[str] = ()) -> "Recording":
        """Return a recording: of the node's topic, or of the bag's own if it has only others."""
        from lagrangian_ff.recording import load

        try:
            return load(bag, topic=self.topic, joints=joints or None)
        except TopicError:
            return load(bag, joints=joints or None)

    def read(
        self,
        bags: Sequence[str],
        joints: Sequence[str],
        conditioning: "Conditioning",
        progress: Progress,
    ) -> "list[Motion]":
        """Return the motions of these joints, of all joints if none is named."""
        from lagrangian_ff.recording import condition_alike

        recordings = []
        for number, bag in enumerate(bags):
            progress(number / len(bags), f"reading {Path(bag).name}")
            recordings.append(self.open_recording(bag, joints))
        return condition_alike(recordings, conditioning)

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


def write_findings(
    output: str, record: Mapping[str, Any], make: Callable[[Path, Any], Path], found: object
) -> dict[str, str]:
    """Write findings as JSON and as a page, and return the files by what to call them.

    Args:
        output: the file of the JSON, which is written whole or not at all.
        record: the JSON; numbers that are not finite become null.
        make, found: what writes the page, and what it writes.

    Raises:
        OSError: the JSON cannot be written.
    """
    path = Path(output)
    path.parent.mkdir(parents=True, exist_ok=True)
    with whole(path) as made:
        made.write_text(to_json(record), "utf-8")
    return {"JSON": output, **write_page(make, path, found)}


def write_page(make: Callable[[Path, Any], Path], beside: Path, found: object) -> dict[str, str]:
    """Write the page beside a file and return its name, or why it failed, by what to call it."""
    try:
        return {"page": str(make(beside.with_suffix(".html"), found))}
    except (UserError, OSError) as error:
        return {"no page because": str(error)}


def lines_of(files: Mapping[str, str]) -> tuple[str, ...]:
    """Return the lines to log about files, which are named by what to call them."""
    return tuple(f"  {label}: {file}" for label, file in files.items())
