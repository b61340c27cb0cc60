"""Diagnosing once, or again and again with what is confirmed added in between."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from lagrangian_ff.cli.common.progress import progress_bar

if TYPE_CHECKING:
    from lagrangian_ff.identification import Model
    from lagrangian_ff.recording import Motion


@dataclass(frozen=True)
class Round:
    """One diagnosis, and the model that it led to.

    Attributes:
        before: the model that was diagnosed.
        record: of the diagnosis, for JSON.
        after: the model with what was confirmed; None where nothing was, or was to be, added.
    """

    before: "Model"
    record: dict[str, Any]
    after: "Model | None"

    @property
    def added(self) -> list[str]:
        """What was added, in words."""
        if self.after is None:
            return []
        new = self.after.steps[len(self.before.steps) :]
        return [str(step["added"]) for step in new]


def diagnosed(
    model: "Model",
    motions: "Sequence[Motion]",
    confirm: "Sequence[Motion]",
    steps: int,
    *,
    apply: bool,
) -> list[Round]:
    """Diagnose; with `apply` add what is confirmed and diagnose again until nothing is.

    Args:
        model: the model.
        motions: what is missing is looked for here.
        confirm: other motion, or none.
        steps: at most so many effects a round, and so many rounds.
        apply: whether to go on.

    Raises:
        ModelError, RecordingError: see `lagrangian_ff.diagnosis.diagnose`.
    """
    from lagrangian_ff import diagnosis as engine
    from lagrangian_ff.diagnosis.consequence import consequences
    from lagrangian_ff.diagnosis.record import diagnosis_record

    rounds: list[Round] = []
    while True:
        title = "diagnosing" if not rounds else f"diagnosing again, round {len(rounds) + 1}"
        with progress_bar(title) as progress:
            found = engine.diagnose(model, motions, confirm, steps=steps, progress=progress)
        with progress_bar("watching the error fall") as progress:
            made = consequences(found, progress)
        record = diagnosis_record(found, made)
        if not apply or not found.confirmed:
            return [*rounds, Round(model, record, None)]
        before = model
        with progress_bar("adding what is confirmed") as progress:
            model = engine.apply(found, made, progress)
        rounds.append(Round(before, record, model))
        del found, made  # which hold a factor
        if len(rounds) == steps:
            return rounds


def falls(rounds: "Sequence[Round]") -> list[dict[str, Any]]:
    """What every addition of all rounds did to the error on the unseen motion.

    Each has `added`, `error` of all joints, and `joint`, `before`, `after` of the one it acts on;
    the first tells the error before anything was added.
    """
    steps: list[dict[str, Any]] = []
    for one in rounds:
        joint = {
            f"{found['effect']} on {found['joints'][0]}": {
                "joint": found["joints"][0],
                "before": found["error_before"],
                "after": found["error_after"],
            }
            for found in one.record["findings"]
        }
        found = one.record["steps"]
        for step in found[1:] if steps else found:
            steps.append({**step, **joint.get(step["added"], {})})
    return steps
