"""Error, and time to fit, over the number of centres."""

from collections.abc import Mapping
from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from lagrangian_ff.report.colours import FAINT
from lagrangian_ff.report.style import new_figure, styled
from lagrangian_ff.studies.common.curves import x_ticks, y_ticks
from lagrangian_ff.studies.common.strokes import DASHED, SOLID, stroke_of

PANELS = (("rmse", "error on motion held out [N·m]"), ("fitting", "processor time to fit [s]"))
DASHES = {"landmarks": SOLID, "samples": DASHED}
SAID = {"landmarks": "all samples", "samples": "the centres alone"}


def sparsity_figure(curves: Mapping[str, Mapping[str, Mapping[str, Any]]]) -> Figure:
    """Draw what `SparsityStudy.numbers` calls `curves`."""
    with styled():
        figure = new_figure(3.9)
        if not curves:
            figure.text(0.5, 0.5, "no case is done", ha="center", color=FAINT)
            return figure
        for axes, (what, title) in zip(figure.subplots(1, 2), PANELS, strict=True):
            _panel(axes, curves, what)
            axes.set_title(title)
        handles, labels = axes.get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside lower center", ncol=len(labels))
    return figure


def _panel(axes: Axes, curves: Mapping[str, Mapping[str, Mapping[str, Any]]], what: str) -> None:
    counts: set[int] = set()
    for model, ways in curves.items():
        for way, one in ways.items():
            axes.plot(
                one["centres"],
                one[what],
                color=stroke_of(model).colour,
                linestyle=DASHES[way],
                marker="o",
                markersize=3.5,
                label=f"{model}, {SAID[way]}",
            )
            counts.update(one["centres"])
    axes.set_xscale("log")
    axes.set_yscale("log")
    x_ticks(axes, sorted(counts))
    y_ticks(axes)
    axes.set_xlabel("centres")
