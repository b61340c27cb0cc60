"""Fig. 6 of the paper: tracking error over speed with precomputed torque."""

from collections.abc import Sequence
from pathlib import Path

from matplotlib.figure import Figure

from lagrangian_ff.studies.arm.drive import drives
from lagrangian_ff.studies.arm.errors import Errors
from lagrangian_ff.studies.arm.models import asked
from lagrangian_ff.studies.arm.plan import Plan
from lagrangian_ff.studies.arm.table import errors_table
from lagrangian_ff.studies.common.case import Line
from lagrangian_ff.studies.common.findings import told
from lagrangian_ff.studies.common.study import Numbers, Request, Study, failures, failures_told
from lagrangian_ff.studies.tracking.case import NONE, TRUE, Tracked
from lagrangian_ff.studies.tracking.figure import MRAD, tracking_figure
from lagrangian_ff.studies.tracking.findings import tracking_findings

MODELS = ("vrbfs+fri", "auto+fri", "vrbfs", "motor+fri")


class TrackingStudy(Study):
    """Position error along trajectories of rising speed, with what is fed forward.

    Args:
        request: `models` are fed forward, beside nothing and the plant's own torques.
        folder: where recordings are kept.

    Raises:
        UserError: there is no such model, or an option is asked that there is not.
    """

    name = "tracking"
    takes = frozenset({"models", "keep"})

    def __init__(self, request: Request, folder: Path) -> None:
        super().__init__(request, folder)
        models = [model for model in request.models if model not in (NONE, TRUE)]
        self._feedforwards = (NONE, TRUE, *asked(models, MODELS))
        self._plan = Plan.of(quick=request.quick)

    def every_case(self) -> Sequence[Tracked]:
        """Along all trajectories without feedforward, with the true one, then model by model."""
        along = drives(self._plan, self.request, self.folder)
        return [
            Tracked(drive, feedforward, self._plan.settings)
            for feedforward in self._feedforwards
            for drive in along
        ]

    def numbers(self, lines: Sequence[Line]) -> Numbers:
        """See `Study.numbers`: `curves` by what is fed forward, `rmse` in rad, and `findings`."""
        errors = Errors.collected(lines, "feedforward", "rmse")
        return {
            "cases": len(lines),
            "failed": failures(lines),
            "curves": errors.record(),
            "findings": tracking_findings(errors),
        }

    def table(self, numbers: Numbers) -> list[str]:
        """The error of position with every feedforward on every trajectory."""
        return [
            f"{numbers['cases']} cases; RMS tracking error [mrad] on the last two thirds",
            *errors_table(numbers["curves"], MRAD),
            *told(numbers["findings"]),
            *failures_told(numbers["failed"]),
        ]

    def figure(self, numbers: Numbers) -> Figure:
        """See `tracking_figure`."""
        return tracking_figure(numbers)
