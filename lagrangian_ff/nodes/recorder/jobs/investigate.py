"""The service ~/investigate: move the arm until it is decided what its model lacks."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

from lagrangian_ff.errors import UserError
from lagrangian_ff.nodes.common.status import Level, Status
from lagrangian_ff.nodes.recorder.jobs import base
from lagrangian_ff.nodes.recorder.jobs.identify import saved
from lagrangian_ff.nodes.recorder.session import Result, SavedModel, new_path
from lagrangian_ff.progress import Progress
from lagrangian_ff.recording import Conditioning
from lagrangian_ff.recording.units import named_units

if TYPE_CHECKING:
    from lagrangian_ff.arrays import Floats
    from lagrangian_ff.diagnosis.excite.keeping import Clear
    from lagrangian_ff.investigation import Investigation, Proposal

PATIENCE = 600.0  # s for which it waits for ~/proceed


@dataclass(frozen=True, kw_only=True)
class Investigate(base.Job):
    """Investigate the arm; the job's process answers ~/proceed and ~/abort meanwhile.

    Attributes:
        node: full name of the node, whose services permit.
        trajectories: the topic that moves the arm.
        joints: which to move, from base to tool; empty for those of the limits or the URDF.
        urdf, limits: files; empty for none.
        speed: share of the highest speeds.
        seconds: of motion, all in all.
        model: to begin with; empty for the usual one.
        effort, units, bandwidth: how the recordings are made ready.
    """

    service, doing, title = "investigate", "investigating", "investigation"
    needs_recordings = False

    node: str
    trajectories: str
    joints: tuple[str, ...] = ()
    urdf: str = ""
    limits: str = ""
    speed: float = 0.5
    seconds: float = 240.0
    model: str = ""
    effort: str = Conditioning.effort
    effort_delay: float = Conditioning.effort_delay
    units: Mapping[str, str] = field(default_factory=dict)
    bandwidth: float = 0.0

    @classmethod
    def request(cls, given: base.Situation) -> "Investigate":
        """Return the request, with the settings of the parameters."""
        value = given.value
        topic = value("investigate.topic")
        urdf, limits = (base.optional(value(f"investigate.{one}")) for one in ("urdf", "limits"))
        if not topic:
            raise UserError(
                "name the topic that moves the arm with the parameter investigate.topic"
            )
        if not (urdf or limits):
            raise UserError(
                "say where the arm may go with the parameter investigate.urdf or investigate.limits"
            )
        return cls(
            **given.common,
            output=str(new_path(given.directory, "investigation", ".json")),
            node=given.node,
            trajectories=topic,
            joints=tuple(filter(None, value("joints"))),
            urdf=urdf,
            limits=limits,
            speed=value("investigate.speed"),
            seconds=60.0 * value("investigate.minutes"),
            model=value("model"),
            effort=value("effort"),
            effort_delay=value("effort_delay"),
            units=named_units(filter(None, value("units"))),
            bandwidth=value("bandwidth"),
        )

    def summary(self) -> str:
        return (
            f"started to investigate the arm that {self.trajectories} moves; it does not move "
            f"before {self.node}/proceed is called"
        )

    def work(self, progress: Progress) -> Result:
        """Move the arm as far as that is permitted; write the story, its page and the model."""
        from lagrangian_ff.diagnosis.excite.excite import inside
        from lagrangian_ff.investigation import Plan, StoppedError, investigate
        from lagrangian_ff.investigation.allowed import allowed
        from lagrangian_ff.nodes.attached.client import Client
        from lagrangian_ff.nodes.attached.rig import connected
        from lagrangian_ff.nodes.common.models import load_own_effects
        from lagrangian_ff.nodes.recorder.desk import Desk

        load_own_effects(self.effects_file)
        progress(0.0, "listening to the arm")
        client = Client(("--ros-args", "-r", f"joint_states:={self.topic}"))
        files = _path(self.urdf), _path(self.limits)
        folder = Path(self.output).with_suffix("")
        with connected(client, self.trajectories, self.joints, *files, folder) as rig:
            desk = Desk(self.node, lambda: rig.stop(f"{self.node}/abort was called"))
            share = 0.0

            def report(done: float, label: str) -> None:
                nonlocal share
                share = done
                progress(done, label)
                if rig.stopped:
                    raise StoppedError(rig.stopped)

            def permit(proposal: "Proposal") -> bool:
                progress(share, f"{proposal.words}{unchecked}: call {self.node}/proceed")
                return desk.ask(PATIENCE)

            try:
                limits = allowed(rig.joints, *files, self.speed)
                start = rig.pose()
                inside("the pose of the arm", start, rig.joints, limits)
                clear, unchecked = self._clear(rig.joints, start)
                plan = Plan(
                    limits,
                    budget=self.seconds,
                    model=self.model,
                    conditioning=self._conditioning(),
                    clear=clear,
                )
                found = investigate(rig, plan, permit, report)
            finally:
                desk.close()
        return self.result(found, tuple(map(str, rig.bags)))

    def result(self, found: "Investigation", bags: tuple[str, ...]) -> Result:
        """Return what is shown of an investigation, whose files are written."""
        from lagrangian_ff.investigation import Ended
        from lagrangian_ff.report import investigation_page

        files = base.write_findings(self.output, found.record(), investigation_page, found)
        model: SavedModel | None = None
        if found.model is not None:
            file = Path(self.output).with_suffix(".npz")
            found.model.save(file)
            model = saved(str(file), found.model.identified)
            files["model"] = str(file)
        names = ", ".join(one.name for one in found.confirmed) or "nothing"
        said = f"confirmed {names} after {found.seconds:.0f} s of motion: {found.words}"
        values: dict[str, object] = {
            **{f"turn {n}": f"{one.asked} {one.answer}" for n, one in enumerate(found.turns, 1)},
            **files,
        }
        calm = found.ended in (Ended.NOTHING_LEFT, Ended.BUDGET) and not found.confirmed
        status = Status(Level.OK if calm else Level.WARN, said, values)
        log = (said, *base.lines_of(files))
        return Result(log, {self.title: status}, model, self.output, bags, found.joints)

    def _conditioning(self) -> Conditioning:
        return Conditioning(
            bandwidth=self.bandwidth or None,
            units=self.units,
            effort=self.effort,
            effort_delay=self.effort_delay,
            effort_scale=self.effort_scale,
            effort_offset=self.effort_offset,
        )

    def _clear(self, joints: tuple[str, ...], start: "Floats") -> "tuple[Clear | None, str]":
        """Return what says whether links touch each other, or None and what to say instead."""
        from lagrangian_ff.diagnosis.excite import Clearance

        try:
            if self.urdf:
                return Clearance.of(Path(self.urdf), joints, start[None]), ""
        except UserError:
            pass  # said in the question
        return None, "; nobody checks whether the arm touches itself"


def _path(text: str) -> Path | None:
    return Path(text) if text else None
