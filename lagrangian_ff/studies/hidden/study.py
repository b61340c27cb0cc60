"""The study of hidden effects: its cases, and what their lines come to."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from matplotlib.figure import Figure

from lagrangian_ff.errors import UserError
from lagrangian_ff.studies.common.case import Line
from lagrangian_ff.studies.common.study import Numbers, Request, Study
from lagrangian_ff.studies.hidden.cases import Case, cases
from lagrangian_ff.studies.hidden.examine import examine
from lagrangian_ff.studies.hidden.examined import Examined
from lagrangian_ff.studies.hidden.examiner import BASE, Diagnosis
from lagrangian_ff.studies.hidden.figure import figure
from lagrangian_ff.studies.hidden.plants import FULL, Stretches
from lagrangian_ff.studies.hidden.table import summary, table


@dataclass(frozen=True)
class Examination:
    """A case, who diagnoses it, and where its recordings are; see `examine`."""

    case: Case
    folder: Path
    stretches: Stretches
    examined: Examined
    keep: bool

    @property
    def name(self) -> str:
        """The case's."""
        return self.case.name

    def run(self) -> Mapping[str, Any]:
        """See `examine`."""
        return examine(self.case, self.folder, self.stretches, self.examined, keep=self.keep)


class HiddenStudy(Study):
    """Is a hidden effect found, and nothing where nothing is hidden?

    Args:
        request: `models` may name the base model.
        folder: where recordings, and runs of the arm without effects, are kept.
        examined: who diagnoses; must be picklable for several jobs. None is the package's own
            diagnosis on the base model.
        stretches: what each recording is made of.

    Raises:
        UserError: more than one base model is asked for.
    """

    name = "hidden"
    takes = frozenset({"models", "keep"})

    def __init__(
        self,
        request: Request,
        folder: Path,
        *,
        examined: Examined | None = None,
        stretches: Stretches = FULL,
    ) -> None:
        super().__init__(request, folder)
        if len(request.models) > 1:
            raise UserError("study hidden has one base model: name one with --models")
        self._base = request.models[0] if request.models else BASE
        self._examined = examined or Diagnosis(self._base)
        self._stretches = stretches

    def identity(self) -> dict[str, Any]:
        """See `Study.identity`."""
        stretches = [list(part) for part in self._stretches.parts]
        return {**super().identity(), "model": self._base, "stretches": stretches}

    def every_case(self) -> Sequence[Examination]:
        """See `Study.every_case`."""
        return [
            Examination(case, self.folder, self._stretches, self._examined, self.request.keep)
            for case in cases(self.request.seed, small=self.request.quick)
        ]

    def numbers(self, lines: Sequence[Line]) -> Numbers:
        """See `summary`."""
        return summary(lines)

    def table(self, numbers: Numbers) -> list[str]:
        """See `table`."""
        return table(numbers)

    def figure(self, numbers: Numbers) -> Figure:
        """See `figure`."""
        return figure(numbers)
