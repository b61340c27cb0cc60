"""The service ~/identify: a model from all recordings of the session."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from lagrangian_ff.errors import UserError
from lagrangian_ff.identification import Settings
from lagrangian_ff.nodes.common.status import Level, Status, held_out
from lagrangian_ff.nodes.recorder.jobs.base import Job, Situation, names_of, optional
from lagrangian_ff.nodes.recorder.session import Session, new_path
from lagrangian_ff.progress import Progress, part


@dataclass(frozen=True, kw_only=True)
class Identify(Job):
    """Identify a model, with the code of the command line.

    Attributes:
        joints: which to identify, in which order; empty for all that were recorded.
        urdf: file of the robot's description; empty if there is none.
        bandwidth: Hz of the low-pass.
        settings: of the identification.
    """

    service, doing, title = "identify", "identifying", "identification"

    joints: tuple[str, ...] = ()
    urdf: str = ""
    bandwidth: float = 25.0
    settings: Settings = field(default_factory=Settings)

    @classmethod
    def request(cls, given: Situation) -> "Identify":
        """Return the request for all recordings, with the settings of the parameters."""
        value, bags, directory = given.value, given.session.bags, given.directory
        stem = f"{bags[-1].name}_model"
        plain = ("model", "train", "samples", "positive", "loss")
        return cls(
            **given.common,
            bags=tuple(map(str, bags)),
            output=str(new_path(directory, stem, ".npz")),
            joints=tuple(filter(None, value("joints"))),
            urdf=_urdf(given, new_path(directory, stem, ".urdf")),
            bandwidth=value("bandwidth"),
            settings=Settings(
                **{name: value(name) for name in plain},
                landmarks=value("landmarks") if value("landmarks") >= 0 else None,
                prismatic=tuple(filter(None, value("prismatic"))),
            ),
        )

    def summary(self) -> str:
        return f"started to identify {self.settings.model} from {names_of(self.bags)}"

    def work(self, progress: Progress) -> dict[str, Any]:
        """Write the model and return its record."""
        from lagrangian_ff.identification import identify
        from lagrangian_ff.kernels.rigid import read_urdf
        from lagrangian_ff.nodes.common.models import load_own_effects
        from lagrangian_ff.recording import Conditioning

        load_own_effects(self.effects_file)
        conditioning = Conditioning(
            bandwidth=self.bandwidth,
            effort_scale=self.effort_scale,
            effort_offset=self.effort_offset,
        )
        motions = self.read(self.bags, self.joints, conditioning, part(progress, 0.0, 0.1))
        mechanism = read_urdf(self.urdf) if self.urdf else None
        found = identify(motions, self.settings, part(progress, 0.1, 1.0), mechanism)
        found.model.save(Path(self.output))
        return dict(found.record)

    def end(self, session: Session, record: dict[str, Any]) -> None:
        session.take_model(Path(self.output), record)

    @classmethod
    def status(cls, record: Mapping[str, Any]) -> Status:
        values = {
            "model": record["model"],
            "held-out RMSE [N·m]": record["rmse"],
            "held-out nMSE": record["nmse"],
            **held_out(record),
        }
        return Status(Level.OK, "identified", values)

    @classmethod
    def statuses(cls, session: Session) -> dict[str, Status]:
        values: dict[str, object] = {"state": session.state, "recordings": len(session.bags)}
        if session.model is not None:
            values |= {"model file": session.model.file, **cls.status(session.model.record).values}
        level, message = Level.OK, "identified" if session.model else "no model yet"
        if failure := session.failures.get(cls.service):
            level, message = Level.ERROR, f"{cls.title} failed: {failure}"
        return {cls.title: Status(level, message, values)}

    def log(self, record: Mapping[str, Any]) -> list[str]:
        return [
            f"identified {record['model']} from {record['samples']} samples in "
            f"{record['seconds']:.1f} s; RMSE {record['rmse']:.4g} N·m, nMSE {record['nmse']:.4g} "
            "on motion it has not seen",
            *(f"  {label}: {error}" for label, error in held_out(record).items()),
            f"  model file: {self.output}",
        ]


def _urdf(given: Situation, file: Path) -> str:
    """Return the file of the robot's description; write it if it came on the topic."""
    named = optional(given.value("urdf"))
    if not given.value("use_robot_description"):
        return named
    if named:
        raise UserError(
            "the parameter urdf names a file and use_robot_description asks for the topic: "
            "set one of the two"
        )
    if not given.description:
        raise UserError(
            "use_robot_description is set, but nothing came on the topic robot_description; start "
            "robot_state_publisher, or name a file with the parameter urdf"
        )
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_text(given.description, encoding="utf-8")
    return str(file)
