"""Fig. 2 of the paper: no friction, no noise, and hardly any regularisation."""

from collections.abc import Sequence

from lagrangian_ff.studies.dof import DofResults, DofStudy, errors_of, order
from lagrangian_ff.studies.robots import Scene
from lagrangian_ff.studies.study import Line

CLAIMS = (
    ("vrbfs", "srbfs", "rbfs"),
    ("vrbf", "srbf", "rbf"),
    ("rbfs", "rbf"),
    ("srbfs", "srbf"),
    ("vrbfs", "vrbf"),
    ("chain", "vrbfs"),
)
"""Each model errs less than those after it: the paper claims all but the last."""
LEAST_JOINTS = 2
"""A single joint leaves nothing for one Lagrangian to share."""


class IdealStudy(DofStudy):
    """How well does each kernel learn rigid bodies?"""

    name = "ideal"
    robots = 16
    usual = (
        "motor", "rbf", "rbfs", "srbf", "srbfs", "vrbf", "vrbfs", "pol",
        "energy_rbf", "energy", "chain_rbf", "chain",
    )  # fmt: skip
    quick_usual = ("rbf", "rbfs", "srbfs", "vrbfs", "chain")
    scene = Scene()
    quick_scene = Scene(training=100, validation=500)
    gamma = 1e-12

    def results(self, lines: Sequence[Line]) -> DofResults:
        """Return the statistics, and whether models stand in the order claimed."""
        errors = errors_of(lines)
        found = [order(errors, claim, LEAST_JOINTS) for claim in CLAIMS]
        return DofResults.of(lines, [each for each in found if each.joints])
