"""Fig. 7 of the paper: error of predicted torque over speed, with masses on the arm."""

from collections.abc import Sequence

from lagrangian_ff.studies.arm.findings import REFERENCE, TRADITIONAL, prediction_findings
from lagrangian_ff.studies.arm.prediction import Prediction
from lagrangian_ff.studies.arm.study import PredictionStudy
from lagrangian_ff.studies.common.case import Line
from lagrangian_ff.studies.common.study import Numbers
from lagrangian_ff.studies.loaded.findings import compared

BESIDE = (TRADITIONAL, REFERENCE)
"""Models that are also learned from the arm without masses, to compare with."""


class LoadedStudy(PredictionStudy):
    """The arm with masses on its first two links; see `PredictionStudy` and `arm.drive.LOADS`."""

    name = "loaded"
    loaded = True

    def every_case(self) -> Sequence[Prediction]:
        """See `PredictionStudy`; then what is compared with, the same cases as in `speeds`."""
        beside = [model for model in BESIDE if model in self.models]
        return [*super().every_case(), *self.predictions(beside, loaded=False)]

    def numbers(self, lines: Sequence[Line]) -> Numbers:
        """See `PredictionStudy`; `unloaded` holds the curves that are compared with."""
        loaded, unloaded = (self.errors(lines, loaded=with_) for with_ in (True, False))
        return {
            **self.counted(lines),
            "unloaded": unloaded.record(),
            "findings": {**prediction_findings(loaded), **compared(loaded, unloaded)},
        }
