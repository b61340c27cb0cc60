"""What Figs. 5 and 7 of the paper have in common: torque error of many models over speed."""

from abc import abstractmethod
from collections.abc import Sequence
from pathlib import Path
from typing import ClassVar

from matplotlib.figure import Figure

from lagrangian_ff.studies.arm.drive import drives
from lagrangian_ff.studies.arm.errors import Errors
from lagrangian_ff.studies.arm.figure import prediction_figure
from lagrangian_ff.studies.arm.models import MODELS, asked
from lagrangian_ff.studies.arm.plan import Plan
from lagrangian_ff.studies.arm.prediction import Prediction
from lagrangian_ff.studies.arm.table import prediction_table
from lagrangian_ff.studies.common.case import Line
from lagrangian_ff.studies.common.study import Numbers, Request, Study, failures

QUICK_MODELS = MODELS[:3]


class PredictionStudy(Study):
    """Torque error on the last two thirds of trajectories of rising speed.

    Args:
        request: `models` are compared; a quick study has three.
        folder: where recordings are kept.

    Raises:
        UserError: there is no such model, or an option is asked that there is not.
    """

    takes = frozenset({"models", "keep"})
    loaded: ClassVar[bool]
    """Whether the arm carries masses."""

    def __init__(self, request: Request, folder: Path) -> None:
        super().__init__(request, folder)
        self.plan = Plan.of(quick=request.quick)
        self.models = asked(request.models, QUICK_MODELS if request.quick else MODELS)

    def every_case(self) -> Sequence[Prediction]:
        """Model by model, each along all trajectories: whoever stops early has whole curves."""
        return self.predictions(self.models, loaded=self.loaded)

    def predictions(self, models: Sequence[str], *, loaded: bool) -> list[Prediction]:
        """Cases of these models along all trajectories."""
        along = drives(self.plan, self.request, self.folder, loaded=loaded)
        return [Prediction(drive, model, self.plan.settings) for model in models for drive in along]

    def errors(self, lines: Sequence[Line], *, loaded: bool) -> Errors:
        """Of the models on the arm with or without masses."""
        here = (line for line in lines if line.get("loaded") is loaded)
        return Errors.collected(here, "model", "rmse")

    @abstractmethod
    def numbers(self, lines: Sequence[Line]) -> Numbers:
        """See `Study.numbers`: `curves` by model, and `findings`."""

    def counted(self, lines: Sequence[Line]) -> Numbers:
        """What the numbers of both studies begin with."""
        return {
            "cases": len(lines),
            "failed": failures(lines),
            "curves": self.errors(lines, loaded=self.loaded).record(),
        }

    def table(self, numbers: Numbers) -> list[str]:
        """See `prediction_table`."""
        return prediction_table(numbers)

    def figure(self, numbers: Numbers) -> Figure:
        """See `prediction_figure`."""
        return prediction_figure(numbers)
