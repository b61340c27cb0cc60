"""Fig. 6 of the paper: error of position over mean velocity, a line a feedforward."""

from collections.abc import Mapping
from typing import Any

from matplotlib.figure import Figure

from lagrangian_ff.report.colours import INK
from lagrangian_ff.studies.arm.figure import VELOCITY, style_of
from lagrangian_ff.studies.arm.models import FRICTION
from lagrangian_ff.studies.common.curves import Curve, curves_figure
from lagrangian_ff.studies.tracking.case import NONE, TRUE

MRAD = 1e-3
SPECIAL = {
    NONE: ("no feedforward", {"colour": INK}),
    TRUE: ("the plant's own torques", {"colour": INK, "dashes": ":"}),
}


def tracking_figure(numbers: Mapping[str, Any]) -> Figure:
    """Draw the numbers of the study; models without friction are dashed."""
    curves = {}
    for name, curve in numbers["curves"].items():
        label, style = SPECIAL.get(name) or (name, _style(name))
        curves[label] = Curve(curve["velocity"], [e / MRAD for e in curve["rmse"]], **style)
    return curves_figure(
        {"Precomputed torque, the last two thirds of each trajectory": curves},
        VELOCITY,
        "RMS tracking error [mrad]",
    )


def _style(model: str) -> dict[str, Any]:
    style = style_of(model)
    return style if FRICTION in model else {**style, "dashes": "--"}
