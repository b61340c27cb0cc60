"""The service ~/identify: a model from all recordings of the session."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING

from lagrangian_ff.errors import UserError
from lagrangian_ff.identification import Settings
from lagrangian_ff.identification.settings import usual_model
from lagrangian_ff.nodes.common.status import Level, Status, errors_of
from lagrangian_ff.nodes.recorder.jobs.base import Job, Situation, lines_of, names_of, optional
from lagrangian_ff.nodes.recorder.session import Result, SavedModel, Session, new_path
from lagrangian_ff.progress import Progress, part
from lagrangian_ff.recording import Conditioning
from lagrangian_ff.recording.units import named_units

if TYPE_CHECKING:
    from lagrangian_ff.identification.records import Identified


@dataclass(frozen=True, kw_only=True)
class Identify(Job):
    """Identify a model, with the code of the command line.

    Attributes:
        joints: which to identify, in which order; empty for all that were recorded.
        urdf: file of the robot's description; empty if there is none.
        units: what was recorded in another unit than s, rad, rad/s or N·m, by quantity.
        bandwidth: Hz of the low-pass; 0 chooses it from the recordings.
        effort: what the recorded effort holds, one of `EFFORTS`.
        settings: of the identification.
    """

    service, doing, title = "identify", "identifying", "identification"

    joints: tuple[str, ...] = ()
    urdf: str = ""
    units: Mapping[str, str] = field(default_factory=dict)
    bandwidth: float = 0.0
    effort: str = Conditioning.effort
    effort_delay: float = Conditioning.effort_delay
    settings: Settings = field(default_factory=Settings)

    @classmethod
    def request(cls, given: Situation) -> "Identify":
        """Return the request for all recordings, with the settings of the parameters."""
        value, bags, directory = given.value, given.session.bags, given.directory
        stem = f"{bags[-1].name}_model"
        plain = ("train", "samples", "positive", "loss")
        return cls(
            **given.common,
            bags=tuple(map(str, bags)),
            output=str(new_path(directory, stem, ".npz")),
            joints=tuple(filter(None, value("joints"))),
            urdf=_urdf(given, new_path(directory, stem, ".urdf")),
            units=named_units(filter(None, value("units"))),
            bandwidth=value("bandwidth"),
            effort=value("effort"),
            effort_delay=value("effort_delay"),
            settings=Settings(
                model=value("model") or usual_model(value("effort")),
                **{name: value(name) for name in plain},
                landmarks=value("landmarks") if value("landmarks") >= 0 else None,
                prismatic=tuple(filter(None, value("prismatic"))),
            ),
        )

    def summary(self) -> str:
        return f"started to identify {self.settings.model} from {names_of(self.bags)}"

    def work(self, progress: Progress) -> Result:
        """Write the model and return its error on motion that it has not seen."""
        from lagrangian_ff.diagnosis.preflight import effort_checks
        from lagrangian_ff.identification import identify, joint_order
        from lagrangian_ff.kernels.rigid import read_urdf
        from lagrangian_ff.nodes.common.models import load_own_effects
        from lagrangian_ff.recording import concatenate

        load_own_effects(self.effects_file)
        conditioning = Conditioning(
            bandwidth=self.bandwidth or None,
            units=self.units,
            effort=self.effort,
            effort_delay=self.effort_delay,
            effort_scale=self.effort_scale,
            effort_offset=self.effort_offset,
        )
        motions = self.read(self.bags, self.joints, conditioning, part(progress, 0.0, 0.1))
        mechanism = read_urdf(self.urdf) if self.urdf else None
        note = ""
        if not self.joints:
            order = joint_order(motions, self.settings.model, mechanism, part(progress, 0.1, 0.2))
            note = order.words(motions[0].joints)
            motions = [motion.select(order.joints) for motion in motions]
        found = identify(motions, self.settings, part(progress, 0.2, 1.0), mechanism)
        found.model.save(Path(self.output))
        result = self.result(found.model.identified)
        said = [f"  {note}; the parameter joints gives another order"] if note else []
        said += [
            f"  {one.finding}. {one.advice}"
            for one in effort_checks(found.model, concatenate(motions))
        ]
        return replace(result, log=(*result.log, *said))

    def result(self, found: "Identified") -> Result:
        """Return what is logged of the model's findings, and the model."""
        log = (
            f"identified {found.model} from {found.samples} samples in {found.seconds:.1f} s; "
            f"RMSE {found.score.total:.4g} N·m, nMSE {found.score.mean_nmse:.4g} on motion it has "
            "not seen",
            *lines_of(errors_of(found.score)),
            f"  model file: {self.output}",
        )
        return Result(log, model=saved(self.output, found))

    @classmethod
    def statuses(cls, session: Session) -> dict[str, Status]:
        values: dict[str, object] = {"state": session.state, "recordings": len(session.bags)}
        if session.model is not None:
            values |= {"model file": session.model.file, **session.model.values}
        level, message = Level.OK, "identified" if session.model else "no model yet"
        if failure := session.failures.get(cls.service):
            level, message = Level.ERROR, f"{cls.title} failed: {failure}"
        return {cls.title: Status(level, message, values)}


def saved(file: str, found: "Identified") -> SavedModel:
    """Return the model of a file with what is shown of its findings."""
    values = {
        "model": found.model,
        "held-out RMSE [N·m]": found.score.total,
        "held-out nMSE": found.score.mean_nmse,
        **errors_of(found.score),
    }
    return SavedModel(Path(file), values)


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
