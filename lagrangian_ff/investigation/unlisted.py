"""Physics that nobody listed: taken in as curves, and formulas proposed for it."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from lagrangian_ff.diagnosis import apply, with_consequences
from lagrangian_ff.diagnosis.confidence import Verdict
from lagrangian_ff.diagnosis.excite import Between, Suspect
from lagrangian_ff.diagnosis.proposing import Proposals, proposals_record, propose
from lagrangian_ff.diagnosis.results import Diagnosis, Finding, Remainder, Unexplained
from lagrangian_ff.errors import UserError
from lagrangian_ff.identification import Model
from lagrangian_ff.identification.basis import Term
from lagrangian_ff.progress import Progress, part, silent
from lagrangian_ff.recording import Motion

MOST = 2
"""Joints for which formulas are proposed, those with the largest torque first."""
AS_GOOD = 1.05
"""Share of the error with a curve, on unseen motion, up to which a formula takes its place."""


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
    def terms(self) -> tuple[Term, ...]:
        """Return the formulas that unseen motion confirms, one a joint, to be taken into a model.

        Where a curve fits the joint clearly better, its formula stays a proposal.
        """
        first = (_confirmed(found) for found in self.proposals)
        joints = self.model.joints
        return tuple(
            Term(one.effect, joints.index(one.joint), one.shape) for one in first if one is not None
        )

    @property
    def open(self) -> tuple[tuple[Between, Finding], ...]:
        """Return which of two formulas is there, where both hold; with the better one, as found."""
        every = (_undecided(found) for found in self.proposals)
        return tuple(one for one in every if one is not None)

    @property
    def effects(self) -> list[dict[str, Any]]:
        """Return the formulas as a file of effects holds them.

        What is proposed for two joints is one of them, with ranges for both.
        """
        held: dict[str, dict[str, Any]] = {}
        for found in self.proposals:
            for one in found.proposals:
                made = one.record()
                shapes = held.get(one.name, made)["shapes"]
                both = {name: _both(shapes[name], own) for name, own in made["shapes"].items()}
                held[one.name] = {**held.get(one.name, made), "shapes": both}
        return list(held.values())

    def beside(self, earlier: Sequence[Proposals]) -> "Unlisted":
        """Return the same with formulas that the model has by now, of other joints or replaced."""
        new = {found.joint for found in self.proposals}
        kept = tuple(found for found in earlier if found.joint not in new)
        return replace(self, proposals=(*kept, *self.proposals))

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


def _confirmed(found: Proposals) -> Finding | None:
    """Return the best formula that is confirmed, and as good as the curve in its place."""
    for one in found.proposals:
        made = one.finding.consequence
        if one.finding.confirmed and made is not None:
            bound = np.inf if found.curve_error is None else AS_GOOD * found.curve_error
            return one.finding if made.whole_after <= bound else None
    return None


def _undecided(found: Proposals) -> tuple[Between, Finding] | None:
    """Return the question about the best formula and its rival, if unseen motion confirms none."""
    findings = [one.finding for one in found.proposals]
    if any(one.confirmed for one in findings):
        return None
    for one in findings:
        rivals = [other for other in findings if other.effect.name in one.rivals]
        if one.verdict is Verdict.AMBIGUOUS and rivals:
            return Between(_suspect(one), _suspect(rivals[0])), one
    return None


def _holds(found: Proposals) -> bool:
    """Return whether a formula is confirmed, or only not told from its rivals."""
    verdicts = (one.finding.verdict for one in found.proposals)
    return any(one in (Verdict.CONFIRMED, Verdict.AMBIGUOUS) for one in verdicts)


def _suspect(found: Finding) -> Suspect:
    return Suspect(found.effect.name, found.joint, found.shape, found.effect)


def _both(first: Sequence[Any], second: Sequence[Any]) -> list[Any]:
    """Return the range of a shape, as JSON holds it, that holds two."""
    low, high, steps = min(first[0], second[0]), max(first[1], second[1]), max(first[2], second[2])
    return [low, high, steps, *first[3:]]


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
        if _holds(made) or joint in {one.joint for one in taken}:
            proposals.append(made)
    if not tried.unexplained and not proposals:
        return None
    return Unlisted(tried.unexplained, taken, model, tuple(proposals))
