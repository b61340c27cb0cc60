"""What is wrong with the recordings that a diagnosis is made on."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

from lagrangian_ff.cli.common.progress import progress_bar

if TYPE_CHECKING:
    from lagrangian_ff.identification import Model
    from lagrangian_ff.recording import Motion

EACH = ("stamps",)
"""Checks that are told of each recording even where nothing is serious."""


def checked(
    model: "Model", motions: "Sequence[Motion]", confirm: "Sequence[Motion]"
) -> list[dict[str, object]]:
    """Records of the preflight, what is serious first.

    What the motion covers is asked of all that is searched together, faults of each recording.

    Args:
        model: the model.
        motions: what is searched.
        confirm: what is confirmed on.
    """
    from lagrangian_ff.diagnosis.preflight import preflight
    from lagrangian_ff.recording.motion import concatenate

    every = [*motions, *confirm]
    alone = len(motions) == 1
    with progress_bar("checking the measurement") as progress:
        whole = [check.record() for check in preflight(model, concatenate(motions), confirm)]
        checks = [one for one in whole if alone or one["check"] not in EACH]
        known = {(one["check"], one["joint"]) for one in checks if one["serious"]}
        for number, motion in enumerate(confirm if alone else every):
            progress(number / len(every), motion.source)
            for check in preflight(model, motion):
                new = (check.check, check.joint) not in known
                if (check.serious and new) or check.check in EACH:
                    checks.append({**check.record(), "source": motion.source})
    return sorted(checks, key=lambda one: not one["serious"])
