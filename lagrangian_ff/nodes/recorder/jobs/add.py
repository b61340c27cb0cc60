"""The service ~/add: a model with more effects, beside the one it was made from."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from lagrangian_ff.errors import UserError
from lagrangian_ff.nodes.common.status import Level, Status
from lagrangian_ff.nodes.recorder.jobs.base import Job, Situation, lines_of, write_page
from lagrangian_ff.nodes.recorder.jobs.diagnose import Addition, Diagnose, Diagnosed
from lagrangian_ff.nodes.recorder.jobs.identify import saved
from lagrangian_ff.nodes.recorder.session import Result, new_path
from lagrangian_ff.progress import Progress, part

if TYPE_CHECKING:
    from lagrangian_ff.identification.history import Step
    from lagrangian_ff.identification.records import Identified


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
            **given.common,
            model_file=str(model),
            output=str(new_path(model.parent, stem.replace("/", "_"), ".npz")),
            additions=additions,
        )

    def summary(self) -> str:
        added, model = " and ".join(map(str, self.additions)), Path(self.model_file).name
        return f"started to add {added} to {model}; it becomes {self.output}"

    def work(self, progress: Progress) -> Result:
        """Write the new model and its page, and return how each step changed the error."""
        from lagrangian_ff.diagnosis import add
        from lagrangian_ff.identification.history import History
        from lagrangian_ff.report import history_page

        model = self.open_model()
        count = len(self.additions)
        for number, each in enumerate(self.additions):
            step = part(progress, number / count, (number + 1) / count)
            model = add(model, each.effect, each.joint, each.shape, each.why, step)
        output = Path(self.output)
        model.save(output)
        page = write_page(history_page, output, History(self.output, model.name, model.history))
        return self.result(model.identified, model.history, page)

    def result(
        self, found: "Identified", steps: "Sequence[Step]", page: Mapping[str, str]
    ) -> Result:
        """Return what was added and how the error on held-out motion changed.

        The model is refitted from the data that it keeps; an effect that came into the arm later
        is not in them.

        Args:
            found, steps: the findings of the new model and its history.
            page: the file of the page by name, or why there is none.
        """
        from lagrangian_ff.identification.history import ErrorChange

        new = steps[-len(self.additions) :]
        error = ErrorChange(new[0].error_before, new[-1].error_after)
        added, level = " and ".join(map(str, self.additions)), Level.OK
        message = (
            f"added {added}: error {error.before:.4g} to {error.after:.4g} N·m on "
            f"{new[-1].judged_on}"
        )
        if not error.fell:
            level = Level.WARN
            message += (
                "; it did not fall, the data that the model keeps do not show the effect: if it "
                "came later, identify again from the new recordings and add it then"
            )
        values = {
            f"step {number}": f"{step.added}: {step.error_after:.4g} N·m"
            for number, step in enumerate(steps, 1)
        }
        log = (message, f"  model file: {self.output}", *lines_of(page))
        status = Status(level, message, {**values, **page})
        return Result(log, {self.title: status}, saved(self.output, found))


def _additions(given: Situation) -> tuple[Addition, ...]:
    effect, joint = given.value("add.effect"), given.value("add.joint")
    if effect and joint:
        return (Addition(effect, joint, why={"why": "a person asked for it"}),)
    if effect or joint:
        missing = "add.joint" if effect else "add.effect"
        raise UserError(f"nothing to add: set the parameter {missing}, too, or leave both empty")
    diagnosis = given.session.results.get(Diagnose.service)
    if not isinstance(diagnosis, Diagnosed):
        raise UserError(
            "nothing to add: call ~/diagnose first, or name an effect and a joint with the "
            "parameters add.effect and add.joint"
        )
    if not diagnosis.confirmed:
        raise UserError(
            "nothing to add: the last diagnosis confirmed no effect; to add one all the same, "
            "name it with the parameters add.effect and add.joint"
        )
    return diagnosis.confirmed
