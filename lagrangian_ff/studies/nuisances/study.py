"""The study of hidden effects in arms with nuisances: each case from the arm to the judgement."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from lagrangian_ff import recording
from lagrangian_ff.diagnosis.results import Found
from lagrangian_ff.errors import UserError
from lagrangian_ff.recording.motion import TOTAL, WITHOUT_GRAVITY, Conditioning, Motion
from lagrangian_ff.recording.recording import Recording
from lagrangian_ff.studies.hidden.study import Answer, Clock, DiagnosisStudy, Examined
from lagrangian_ff.studies.hidden.verdicts import Truth, claims, judge
from lagrangian_ff.studies.nuisances.drawn import Nuisances
from lagrangian_ff.studies.nuisances.plants import NuisanceCase, cases, recorded
from lagrangian_ff.studies.nuisances.results import NuisanceResults
from lagrangian_ff.studies.study import Line, Request

BASE = "auto+fri"


@dataclass(frozen=True)
class NuisanceExamination:
    """A case of the study.

    Attributes:
        case: the arm.
        folder: of the study.
        examined: who diagnoses.
        keep: keep the recordings in the folder, and use those that are there.
        longest: s of a motion; None leaves it as it is drawn.
    """

    case: NuisanceCase
    folder: Path
    examined: Examined
    keep: bool = False
    longest: float | None = None

    @property
    def name(self) -> str:
        """Return the arm's name."""
        return self.case.name

    def record(self) -> None:
        """Record the arm, and keep that."""
        recorded(self.case, self.folder, keep=True, longest=self.longest)

    def run(self) -> Mapping[str, Any]:
        """Record the arm, have it diagnosed, and judge the diagnosis.

        Returns:
            The `plant`, the diagnosis's `record`, the `judgement`, the `errors` of the base model
            by joint on the second recording, what adding each confirmed finding did to the error
            there (`added`), and why the diagnosis refused to judge (`refused`), if it did. Refusing
            is saying nothing.
        """
        clock, who = Clock(), self.examined
        first, second, plant = recorded(
            self.case, self.folder, keep=self.keep, longest=self.longest
        )
        clock.lap("recording")
        answer, errors, refused = Answer([], {}), dict[str, float](), None
        try:
            motion, confirm = _conditioned(first, second, plant.nuisances)
            model = who.identify(motion)
            clock.lap("identification")
            errors = dict(who.errors(model, confirm))
            answer = who.diagnose(model, motion, confirm)
        except UserError as error:
            refused = str(error)
        clock.lap("diagnosis")
        truths = [Truth(tuple(each.catalogue), tuple(each.joints)) for each in plant.hidden]
        judgement = judge(truths, answer.findings, plant.nuisances.allowed)
        return {
            "group": self.case.group,
            "plant": plant.record(),
            "record": answer.record,
            "judgement": judgement.record(),
            "errors": errors,
            "added": [_added(one) for one in answer.findings if claims(one) and one.consequence],
            "refused": refused,
            "seconds": clock.laps,
        }


def _conditioned(first: Recording, second: Recording, nuisances: Nuisances) -> list[Motion]:
    """Return both motions, conditioned as by a user who knows what the driver's effort is."""
    effort = WITHOUT_GRAVITY if nuisances.without_gravity else TOTAL
    return recording.condition_alike([first, second], Conditioning(effort=effort))


def _added(finding: Found) -> dict[str, Any]:
    """Return what adding a finding did to the unseen error of all joints, in N·m."""
    made = finding.consequence
    assert made is not None
    about = {"effect": finding.effect.name, "joint": finding.joints[0]}
    made = made.beside or made
    return {**about, "before": made.every_before, "after": made.every_after}


class NuisancesStudy(DiagnosisStudy):
    """Is a hidden effect found in an arm with nuisances, and is nothing wrong named?

    Args:
        request, folder, examined: see `DiagnosisStudy`.
        longest: s of a motion; None leaves it as it is drawn.
    """

    name = "nuisances"

    def __init__(
        self,
        request: Request,
        folder: Path,
        *,
        examined: Examined | None = None,
        longest: float | None = None,
    ) -> None:
        super().__init__(request, folder, BASE, examined)
        self._longest = longest

    def identity(self) -> dict[str, Any]:
        """Return what identifies the study, the length of its motions too."""
        return {**super().identity(), "longest": self._longest}

    def every_case(self) -> Sequence[NuisanceExamination]:
        """Return the cases, all groups mixed."""
        keep = self.request.keep
        return [
            NuisanceExamination(case, self.folder, self._examined, keep, self._longest)
            for case in cases(self.request.seed, small=self.request.quick)
        ]

    def results(self, lines: Sequence[Line]) -> NuisanceResults:
        return NuisanceResults.of(lines)
