"""Fig. 3: viscous and Coulomb friction, noise, and every kernel with and without `fri`."""

from collections.abc import Sequence
from typing import Any

from matplotlib.figure import Figure

from lagrangian_ff.studies.common.case import Line
from lagrangian_ff.studies.common.study import Numbers
from lagrangian_ff.studies.dof.curves import curves
from lagrangian_ff.studies.dof.study import DofStudy
from lagrangian_ff.studies.friction.findings import findings
from lagrangian_ff.studies.robots.samples import Scene

KERNELS = (
    "rbf", "rbfs", "srbf", "srbfs", "vrbf", "vrbfs",
    "energy_rbf", "energy", "chain_rbf", "chain",
)  # fmt: skip
QUICK = ("srbfs", "vrbfs", "chain")


def _both(kernels: Sequence[str]) -> tuple[str, ...]:
    return tuple(model for kernel in kernels for model in (kernel, f"{kernel}+fri"))


class FrictionStudy(DofStudy):
    """What is friction to a kernel that does not know it, and to one that does? See `DofStudy`."""

    name = "friction"
    robots = 8
    models = _both(KERNELS)
    quick_models = _both(QUICK)
    scene = Scene(friction=True, noise=0.05)
    quick_scene = Scene(training=100, validation=500, friction=True, noise=0.05)
    gamma = None

    def comparisons(self, lines: Sequence[Line]) -> list[dict[str, Any]]:
        """See `findings`."""
        return findings(lines)

    def figure(self, numbers: Numbers) -> Figure:
        """See `curves`."""
        models = numbers["models"]
        knowing = {model: rows for model, rows in models.items() if model.endswith("+fri")}
        without = {model: rows for model, rows in models.items() if model not in knowing}
        rows = ((", without fri", without), (", with fri", knowing))
        return curves([(title, held) for title, held in rows if held])
