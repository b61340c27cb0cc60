"""The work of `diagnose`: check the measurement, diagnose, and add what is confirmed in rounds."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

from lagrangian_ff.cli.common.console import progress_bar

if TYPE_CHECKING:
    from lagrangian_ff.diagnosis import Diagnosis
    from lagrangian_ff.diagnosis.results import Consequences
    from lagrangian_ff.identification import Model
    from lagrangian_ff.recording import Motion


CHECKED_EACH = ("stamps",)
"""Checks that are shown of each recording even if nothing is serious."""


@dataclass(frozen=True)
class Round:
    """One diagnosis, and the model that it led to.

    Attributes:
        diagnosis: the diagnosis.
        made: the consequences of adding its findings.
        after: the model with what was confirmed; None if nothing was, or was to be, added.
    """

    diagnosis: "Diagnosis"
    made: "Consequences"
    after: "Model | None"

    @cached_property
    def record(self) -> dict[str, Any]:
        """Return the record of the diagnosis, for JSON."""
        from lagrangian_ff.diagnosis import diagnosis_record

        return diagnosis_record(self.diagnosis, self.made)

    @property
    def added(self) -> list[str]:
        """Return what was added, in words."""
        if self.after is None:
            return []
        new = self.after.steps[len(self.diagnosis.model.steps) :]
        return [str(step["added"]) for step in new]


def checked(
    model: "Model", motions: "Sequence[Motion]", confirm: "Sequence[Motion]"
) -> list[dict[str, object]]:
    """Return the records of the preflight, what is serious first.

    What the motion covers is checked for all that is searched together, faults for each recording.

    Args:
        motions: what is searched.
        confirm: other motion, or none.
    """
    from lagrangian_ff.diagnosis.preflight import preflight
    from lagrangian_ff.recording.motion import concatenate

    every = [*motions, *confirm]
    alone = len(motions) == 1
    with progress_bar("checking the measurement") as progress:
        whole = [check.record() for check in preflight(model, concatenate(motions), confirm)]
        checks = [one for one in whole if alone or one["check"] not in CHECKED_EACH]
        known = {(one["check"], one["joint"]) for one in checks if one["serious"]}
        for number, motion in enumerate(confirm if alone else every):
            progress(number / len(every), motion.source)
            for check in preflight(model, motion):
                new = (check.check, check.joint) not in known
                if (check.serious and new) or check.check in CHECKED_EACH:
                    checks.append({**check.record(), "source": motion.source})
    return sorted(checks, key=lambda one: not one["serious"])


def diagnosed(
    model: "Model", motions: "Sequence[Motion]", confirm: "Sequence[Motion]", steps: int, *,
    apply: bool,
) -> list[Round]:  # fmt: skip
    """Diagnose; with `apply` add what is confirmed and diagnose again until nothing is confirmed.

    Args:
        motions, confirm: see `checked`.
        steps: the most effects a round, and the most rounds.
        apply: whether to add what is confirmed.

    Raises:
        ModelError, RecordingError: see `lagrangian_ff.diagnosis.diagnose`.
    """
    from lagrangian_ff import diagnosis as engine

    rounds: list[Round] = []
    while True:
        title = "diagnosing" if not rounds else f"diagnosing again, round {len(rounds) + 1}"
        with progress_bar(title) as progress:
            found = engine.diagnose(model, motions, confirm, steps=steps, progress=progress)
        with progress_bar("watching the error fall") as progress:
            made = engine.consequences(found, progress)
        if not apply or not found.confirmed:
            return [*rounds, Round(found, made, None)]
        with progress_bar("adding what is confirmed") as progress:
            model = engine.apply(found, made, progress)
        rounds.append(Round(found, made, model))
        if len(rounds) == steps:
            return rounds


def falls(rounds: "Sequence[Round]") -> list[dict[str, Any]]:
    """Return what every addition of all rounds did to the error on the unseen motion.

    Each has `added`, `error` of all joints, and `joint`, `before`, `after` of the joint it acts on;
    the first has the error before anything was added.
    """
    steps: list[dict[str, Any]] = []
    for one in rounds:
        added = [(found, one.made[found]) for found in one.diagnosis.confirmed if found in one.made]
        if added and not steps:
            steps.append({"added": None, "error": added[0][1].every_before})
        steps += [
            {
                "added": f"{found.effect.name} on {found.joint}",
                "error": made.every_after,
                "joint": found.joint,
                "before": made.whole_before,
                "after": made.whole_after,
            }
            for found, made in added
        ]
    return steps
