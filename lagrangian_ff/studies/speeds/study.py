"""Fig. 5 of the paper: error of predicted torque over speed."""

from collections.abc import Sequence

from lagrangian_ff.studies.arm.findings import prediction_findings
from lagrangian_ff.studies.arm.study import PredictionStudy
from lagrangian_ff.studies.common.case import Line
from lagrangian_ff.studies.common.study import Numbers


class SpeedsStudy(PredictionStudy):
    """The arm as it is; see `PredictionStudy`."""

    name = "speeds"
    loaded = False

    def numbers(self, lines: Sequence[Line]) -> Numbers:
        """See `PredictionStudy`."""
        findings = prediction_findings(self.errors(lines, loaded=False))
        return {**self.counted(lines), "findings": findings}
