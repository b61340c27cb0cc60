"""Fig. 2: no friction, no noise, and hardly any regularisation."""

from collections.abc import Sequence

from matplotlib.figure import Figure

from lagrangian_ff.studies.common.case import Line
from lagrangian_ff.studies.common.study import Numbers
from lagrangian_ff.studies.dof.curves import curves
from lagrangian_ff.studies.dof.numbers import Comparison, order
from lagrangian_ff.studies.dof.study import DofStudy
from lagrangian_ff.studies.robots.samples import Scene

CLAIMS = (
    ("vrbfs", "srbfs", "rbfs"),
    ("vrbf", "srbf", "rbf"),
    ("rbfs", "rbf"),
    ("srbfs", "srbf"),
    ("vrbfs", "vrbf"),
    ("chain", "vrbfs"),
)
"""Models that are said to err less than those after them: all but the last by the paper."""
LEAST_JOINTS = 2
"""A single joint leaves nothing for one Lagrangian to share."""


class IdealStudy(DofStudy):
    """How well are rigid bodies learned by which kernel? See `DofStudy`."""

    name = "ideal"
    robots = 16
    models = (
        "motor", "rbf", "rbfs", "srbf", "srbfs", "vrbf", "vrbfs", "pol",
        "energy_rbf", "energy", "chain_rbf", "chain",
    )  # fmt: skip
    quick_models = ("rbf", "rbfs", "srbfs", "vrbfs", "chain")
    scene = Scene()
    quick_scene = Scene(training=100, validation=500)
    gamma = 1e-12

    def comparisons(self, lines: Sequence[Line]) -> list[Comparison]:
        """See `DofStudy.comparisons`."""
        found = [order(lines, claim, LEAST_JOINTS) for claim in CLAIMS]
        return [finding for finding in found if finding["joints"]]

    def figure(self, numbers: Numbers) -> Figure:
        """See `curves`."""
        return curves([("", numbers["models"])])
