"""The service ~/add: a model with more effects, beside the one it was made from."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from lagrangian_ff.errors import UserError
from lagrangian_ff.nodes.common.status import Level, Status
from lagrangian_ff.nodes.recorder.jobs.base import Job, Situation, files_of, write_page
from lagrangian_ff.nodes.recorder.jobs.diagnose import CONFIRMED, Diagnose
from lagrangian_ff.nodes.recorder.session import Session, new_path
from lagrangian_ff.progress import Progress, part
from lagrangian_ff.record_json import why_of


@dataclass(frozen=True)
class Addition:
    """An effect to add to a model.

    Attributes:
        effect: a name of the catalogue.  joint: where it acts.
        shape: nonlinear parameters; the others are searched.
        why: the reason for the model's history.
    """

    effect: str
    joint: str
    shape: Mapping[str, float] | None = None
    why: Mapping[str, object] = field(default_factory=dict)

    def __str__(self) -> str:
        return f"{self.effect} on {self.joint}"


@dataclass(frozen=True, kw_only=True)
class Add(Job):
    """Add effects to a model.

    Attributes:
        additions: what to add, one after the other.
    """

    service, doing, title, needs_recordings = "add", "adding", "addition", False

    additions: tuple[Addition, ...] = ()

    @classmethod
    def request(cls, given: Situation) -> "Add":
        """Return the request for the effect of the parameters, else for what was confirmed."""
        model = given.present_model
        additions = _additions(given)
        stem = "_".join([model.stem, *(f"{each.effect}_{each.joint}" for each in additions)])
        return cls(
            **given.common, model_file=str(model),
            output=str(new_path(model.parent, stem.replace("/", "_"), ".npz")), additions=additions,
        )  # fmt: skip

    def summary(self) -> str:
        added, model = " and ".join(map(str, self.additions)), Path(self.model_file).name
        return f"started to add {added} to {model}; it becomes {self.output}"

    def work(self, progress: Progress) -> dict[str, Any]:
        """Write the new model and its page; return its record and its steps."""
        from lagrangian_ff.diagnosis import add, history
        from lagrangian_ff.report import history_page

        model = self.open_model()
        count = len(self.additions)
        for number, each in enumerate(self.additions):
            step = part(progress, number / count, (number + 1) / count)
            model = add(model, each.effect, each.joint, each.shape, each.why, step)
        output = Path(self.output)
        model.save(output)
        steps = {**history(model), "model": str(output)}
        return {
            "record": dict(model.record),
            "steps": steps["steps"],
            "added": [str(each) for each in self.additions],
            **write_page(history_page, output, steps),
        }

    def end(self, session: Session, record: dict[str, Any]) -> None:
        session.take_model(Path(self.output), record["record"])
        super().end(session, record)

    @classmethod
    def status(cls, record: Mapping[str, Any]) -> Status:
        """Return what was added and how the error on held-out motion changed.

        The model is refitted from the data that it keeps; an effect that came into the arm later
        is not in them.
        """
        steps = record["steps"][-len(record["added"]) :]
        before, after = steps[0]["error_before"], steps[-1]["error_after"]
        message = (
            f"added {' and '.join(record['added'])}: error {before:.4g} to {after:.4g} N·m on "
            f"{steps[-1]['judged_on']}"
        )
        if not after < before:
            message += (
                "; it did not fall, the data that the model keeps do not show the effect: if it "
                "came later, identify again from the new recordings and add it then"
            )
        history = {
            f"step {number}": f"{step['added']}: {step['error_after']:.4g} N·m"
            for number, step in enumerate(record["steps"], 1)
        }
        level = Level.OK if after < before else Level.WARN
        return Status(level, message, {**history, **files_of(record)})

    def details(self, record: Mapping[str, Any]) -> list[str]:
        return [f"  model file: {self.output}"]


def _additions(given: Situation) -> tuple[Addition, ...]:
    effect, joint = given.value("add.effect"), given.value("add.joint")
    if effect and joint:
        return (Addition(effect, joint, why={"why": "a person asked for it"}),)
    if effect or joint:
        missing = "add.joint" if effect else "add.effect"
        raise UserError(f"nothing to add: set the parameter {missing}, too, or leave both empty")
    diagnosis = given.session.found.get(Diagnose.service)
    if diagnosis is None:
        raise UserError(
            "nothing to add: call ~/diagnose first, or name an effect and a joint with the "
            "parameters add.effect and add.joint"
        )
    confirmed = tuple(
        Addition(one["effect"], one["joints"][0], one["shape"], why_of(one))
        for one in diagnosis["findings"]
        # A load or a contact, without a `why`, belongs to the recording and is not added.
        if one["verdict"] == CONFIRMED and one["why"]
    )
    if not confirmed:
        raise UserError(
            "nothing to add: the last diagnosis confirmed no effect; to add one all the same, "
            "name it with the parameters add.effect and add.joint"
        )
    return confirmed
