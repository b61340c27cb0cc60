"""Figs. 5 and 7 of the paper: error of predicted torque over mean velocity, a line a model."""

from collections.abc import Iterator, Mapping
from typing import Any

from matplotlib.figure import Figure

from lagrangian_ff.studies.arm.models import FRICTION, OURS
from lagrangian_ff.studies.common.curves import Curve, curves_figure
from lagrangian_ff.studies.common.strokes import stroke_of

VELOCITY = "mean norm of velocity [rad/s]"


def style_of(model: str) -> dict[str, Any]:
    """How a model is drawn in every figure; the default of ours stands out."""
    stroke = stroke_of(model)
    return {"colour": stroke.colour, "dashes": stroke.dashes, "strong": model == OURS[0]}


def prediction_figure(numbers: Mapping[str, Any]) -> Figure:
    """Draw kernels alone and kernels with friction side by side.

    Args:
        numbers: `curves` by model, and perhaps `unloaded`, drawn dotted to compare with.
    """
    alone, beside = "kernel alone", "friction beside the kernel"
    panels: dict[str, dict[str, Curve]] = {alone: {}, beside: {}}
    for name, style, curve in _lines(numbers):
        panel = panels[beside if FRICTION in name else alone]
        panel[name] = Curve(curve["velocity"], curve["rmse"], **style)
    return curves_figure(panels, VELOCITY, "RMS error of torque [N·m]")


def _lines(numbers: Mapping[str, Any]) -> Iterator[tuple[str, dict[str, Any], Any]]:
    for model, curve in numbers.get("unloaded", {}).items():
        yield f"{model}, unloaded", {"colour": style_of(model)["colour"], "dashes": ":"}, curve
    for model, curve in numbers["curves"].items():
        yield model, style_of(model), curve
