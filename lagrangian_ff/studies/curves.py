"""Drawing: a stroke for each kernel, and curves with their names at their ends."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import NullLocator

from lagrangian_ff.arrays import Floats
from lagrangian_ff.report.colours import FAINT, INK, RUNS
from lagrangian_ff.report.style import new_figure, styled

GREY, AMBER, BLUE, GREEN, VIOLET, RED = RUNS
SOLID, DASHED, DOTTED = "-", (0, (4, 2)), (0, (1, 1.5))
HEIGHT = 5.4  # inches
SIZE = 8.0  # points, of the names
APART = 1.25 * SIZE / 72.0 / (0.84 * HEIGHT)
"""The least distance between names, as a share of a panel's height."""
PLAIN_TICKS, FINE_TICKS = (1.0, 2.0, 5.0), (1.0, 1.2, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 8.0)
WIDE = 5.0
"""Plain ticks do where the largest value is more than this times the least."""


Look = dict[str, Any]
"""Keywords of matplotlib."""


@dataclass(frozen=True)
class Stroke:
    """The stroke of a kernel in every study, whatever stands beside it.

    Attributes:
        colour: of the family.
        dashes: solid where positions are angles, by (39).
        ours: not of the paper.
    """

    colour: str
    dashes: Any = SOLID
    ours: bool = False

    @property
    def line(self) -> Look:
        """Return the stroke as matplotlib takes it."""
        return {"color": self.colour, "linestyle": self.dashes}


STROKES: Mapping[str, Stroke] = {
    "motor": Stroke(FAINT, DOTTED),
    "rbf": Stroke(GREY, DASHED),
    "rbfs": Stroke(GREY),
    "srbf": Stroke(AMBER, DASHED),
    "srbfs": Stroke(AMBER),
    "svrbf": Stroke(AMBER, (0, (4, 1.5, 1, 1.5))),
    "svrbfs": Stroke(AMBER, DOTTED),
    "vrbf": Stroke(BLUE, DASHED),
    "vrbfs": Stroke(BLUE),
    "pol": Stroke(INK, DOTTED),
    "energy_rbf": Stroke(GREEN, DASHED, ours=True),
    "energy": Stroke(GREEN, ours=True),
    "chain_rbf": Stroke(VIOLET, DASHED, ours=True),
    "chain": Stroke(VIOLET, ours=True),
    "auto": Stroke(RED, ours=True),
}
OTHER = Stroke(INK)


def stroke_of(model: str) -> Stroke:
    """Return the stroke of a model's kernel."""
    return STROKES.get(model.partition("+")[0], OTHER)


@dataclass(frozen=True)
class Curve:
    """A line.

    Attributes:
        x, y: its points, y above 0.
        stroke: its colour and dashes.
        strong: drawn above the others, and wider.
    """

    x: Sequence[float]
    y: Sequence[float]
    stroke: Stroke = OTHER
    strong: bool = False


def curves_figure(
    panels: Mapping[str, Mapping[str, Curve]],
    x_label: str,
    y_label: str,
    *,
    logarithmic: bool = False,
) -> Figure:
    """Draw panels side by side with common axes, y in decades.

    Args:
        panels: by title, curves by name; panels without a curve are left out.
        x_label, y_label: with units.
        logarithmic: whether x is in decades too.
    """
    drawn = {title: curves for title, curves in panels.items() if curves}
    with styled():
        figure = new_figure(HEIGHT)
        if not drawn:
            figure.text(0.5, 0.5, "no case is done", ha="center", color=FAINT)
            return figure
        row = figure.subplots(1, len(drawn), sharex=True, sharey=True, squeeze=False)[0]
        for axes, (title, curves) in zip(row, drawn.items(), strict=True):
            for curve in curves.values():
                _draw(axes, curve)
            axes.set_title(title)
            axes.set_xlabel(x_label)
        if logarithmic:
            row[0].set_xscale("log")
            every = (curve for curves in drawn.values() for curve in curves.values())
            x_ticks(row[0], sorted({x for curve in every for x in curve.x}))
        row[0].set_yscale("log")
        row[0].set_ylabel(y_label)
        y_ticks(row[0])
        for axes, curves in zip(row, drawn.values(), strict=True):
            _name(axes, curves)
    return figure


def _draw(axes: Axes, curve: Curve) -> None:
    width, dot, above = (2.2, 4.5, 3.0) if curve.strong else (1.2, 3.0, 2.0)
    dots: Look = {"marker": "o", "markersize": dot, "markeredgewidth": 0.0}
    axes.plot(curve.x, curve.y, **curve.stroke.line, **dots, linewidth=width, zorder=above)


def y_ticks(axes: Axes) -> None:
    """Label an axis in decades with plain numbers."""
    low, high = axes.get_ylim()
    steps = PLAIN_TICKS if high > WIDE * low else FINE_TICKS
    decades = range(int(np.floor(np.log10(low))), int(np.ceil(np.log10(high))) + 1)
    ticks = [step * 10.0**decade for decade in decades for step in steps]
    axes.minorticks_off()
    axes.set_yticks(ticks, [f"{tick:g}" for tick in ticks])
    axes.set_ylim(low, high)


def x_ticks(axes: Axes, values: Sequence[float]) -> None:
    """Label an axis in decades with the values themselves."""
    axes.set_xticks(values, [f"{value:g}" for value in values])
    axes.xaxis.set_minor_locator(NullLocator())


def _name(axes: Axes, curves: Mapping[str, Curve]) -> None:
    """Write each name at the end of its curve, moved where two names would overlap."""
    low, high = np.log(axes.get_ylim())
    ordered = sorted(curves, key=lambda name: curves[name].y[-1])
    ends = np.array([(np.log(curves[name].y[-1]) - low) / (high - low) for name in ordered])
    for name, place in zip(ordered, spread(ends, APART), strict=True):
        curve = curves[name]
        colour, weight = curve.stroke.colour, "bold" if curve.strong else "normal"
        font: Look = {"va": "center", "fontsize": SIZE, "fontweight": weight, "color": colour}
        line = {"arrowstyle": "-", "color": colour, "linewidth": 0.5, "alpha": 0.5}
        arrow: Look = {**line, "relpos": (0.0, 0.5), "shrinkA": 1.0, "shrinkB": 3.0}
        end, beside = (curve.x[-1], curve.y[-1]), (1.03, place)
        axes.annotate(name, end, beside, textcoords="axes fraction", arrowprops=arrow, **font)


def spread(places: Floats, apart: float) -> Floats:
    """Return rising places (K,), moved so that neighbours are at least `apart` from each other.

    Places that crowd spread about their middle.
    """
    crowds: list[list[float]] = []
    for place in places:
        crowds.append([float(place)])
        while len(crowds) > 1 and _in_a_row(crowds[-1], apart)[0] < (
            _in_a_row(crowds[-2], apart)[-1] + apart
        ):
            crowds[-2:] = [crowds[-2] + crowds[-1]]
    return np.concatenate([_in_a_row(crowd, apart) for crowd in crowds])


def _in_a_row(crowd: list[float], apart: float) -> Floats:
    steps = np.arange(len(crowd), dtype=np.float64)
    return np.mean(crowd) + apart * (steps - steps.mean())
