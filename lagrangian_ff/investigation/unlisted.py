"""Physics that nobody listed: taken in as curves, and formulas proposed for it."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from lagrangian_ff.diagnosis import apply, with_consequences
from lagrangian_ff.diagnosis.proposing import Proposals, proposals_record, propose
from lagrangian_ff.diagnosis.results import Diagnosis, Remainder, Unexplained
from lagrangian_ff.errors import UserError
from lagrangian_ff.identification import Model
from lagrangian_ff.progress import Progress, part, silent
from lagrangian_ff.recording import Motion

MOST = 2
"""Joints for which formulas are proposed, those with the largest torque first."""


@dataclass(frozen=True, eq=False)
class Unlisted:
    """The torques that no effect of the catalogue fits, at the end of an investigation.

    Attributes:
        left: each torque, with what its curve does to the error.
        taken: those whose curves lower the error; the model has them.
        model: with all that is confirmed and these curves.
        proposals: formulas, joint by joint.
    """

    left: tuple[Unexplained, ...]
    taken: tuple[Unexplained, ...]
    model: Model
    proposals: tuple[Proposals, ...]

    @property
    def effects(self) -> list[dict[str, Any]]:
        """Return the formulas as a file of effects holds them."""
        return [one.record() for found in self.proposals for one in found.proposals]

    def record(self) -> dict[str, Any]:
        """Return it for JSON."""
        return {
            "left": [
                {
                    "joint": one.joint,
                    "coordinate": one.coordinate,
                    "share": one.share,
                    "log_bayes_factor": one.log_bayes_factor,
                    "taken": one in self.taken,
                }
                for one in self.left
            ],
            "proposals": [proposals_record(one) for one in self.proposals],
        }


def take_in(
    found: Diagnosis,
    learned: Sequence[Motion],
    unseen: Sequence[Motion],
    progress: Progress = silent,
) -> Unlisted | None:
    """Return what a diagnosis leaves unexplained, as curves and formulas; None if there is nothing.

    Formulas are proposed, too, for a joint where more than noise is left of which not even the
    coordinate is known.

    Args:
        learned: motion that was searched.  unseen: motion that judges.
        progress: receives the share done, 0 to 1.
    """
    if not found.unexplained and not found.remainders:
        return None
    tried = with_consequences(found, part(progress, 0.0, 0.3))
    model = apply(tried, curves=True)
    taken = tuple(one for one, _ in tried.curves)
    left: list[Unexplained | Remainder] = [*taken, *found.remainders]
    left.sort(key=lambda one: -one.share)
    joints = list(dict.fromkeys(one.joint for one in left))[:MOST]
    proposals = []
    for number, joint in enumerate(joints):
        begin = 0.3 + 0.7 * number / len(joints)
        here = part(progress, begin, begin + 0.7 / len(joints))
        try:
            made = propose(model, learned, unseen, joint, progress=here)
        except UserError:  # nothing of the kind moves: the joint stays without a formula
            continue
        if any(one.finding.confirmed for one in made.proposals) or joint in {
            t.joint for t in taken
        }:
            proposals.append(made)
    if not tried.unexplained and not proposals:
        return None
    return Unlisted(tried.unexplained, taken, model, tuple(proposals))
