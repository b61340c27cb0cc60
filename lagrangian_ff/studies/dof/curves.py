"""Error against the number of joints, one line a model, as in Figs. 2 and 3."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, MaxNLocator, NullFormatter

from lagrangian_ff.report.colours import FAINT
from lagrangian_ff.report.style import new_figure, styled
from lagrangian_ff.studies.common.strokes import stroke_of

FLOOR = {"mean": 1e-8, "variance": 1e-16}
"""What is smaller is drawn here: exact but for rounding, and no reason to squeeze the rest."""

Statistics = Mapping[str, Mapping[str, Mapping[str, Any]]]


def curves(rows: Sequence[tuple[str, Statistics]]) -> Figure:
    """Draw mean and variance side by side.

    Args:
        rows: for each row of panels its title, and by model and number of joints the statistics
            of `numbers_of`.
    """
    rows = rows or [("", {})]
    with styled():
        figure = new_figure(0.9 + 3.5 * len(rows))
        panels = figure.subplots(len(rows), 2, squeeze=False, sharex=True, sharey="col")
        letters = iter("abcdefgh")
        for (title, models), pair in zip(rows, panels, strict=True):
            for axes, what in zip(pair, ("mean", "variance"), strict=True):
                _panel(axes, models, what)
                axes.set_title(f"({next(letters)})  {what} of the error{title}")
            ending = sorted(models, key=lambda model: -_at_end(models[model]))
            by_label = dict(zip(*reversed(pair[0].get_legend_handles_labels()), strict=True))
            handles = [by_label[model] for model in ending]
            pair[1].legend(handles, ending, loc="upper left", bbox_to_anchor=(1.01, 1.0))
            pair[0].set_ylabel("rms error / largest torque")
        for axes in panels[-1]:
            axes.set_xlabel("joints")
    return figure


def _panel(axes: Axes, models: Statistics, what: str) -> None:
    floored = False
    for model, statistics in models.items():
        stroke = stroke_of(model)
        joints = [int(n) for n in statistics]
        known = [np.nan if row[what] is None else row[what] for row in statistics.values()]
        values = np.maximum(known, FLOOR[what])
        floored |= bool(np.any(values == FLOOR[what]))
        axes.plot(
            joints,
            values,
            color=stroke.colour,
            linestyle=stroke.dashes,
            linewidth=1.7 if stroke.ours else 1.2,
            marker="o" if stroke.ours else None,
            markersize=3.5,
            zorder=3 if stroke.ours else 2,
            label=model,
        )
    axes.set_yscale("log")
    if floored:
        axes.set_ylim(bottom=0.5 * FLOOR[what])
        axes.text(1.0, FLOOR[what], "or less", transform=axes.get_yaxis_transform(), fontsize=7,
                  color=FAINT, ha="right", va="bottom")  # fmt: skip
    axes.yaxis.set_major_locator(LogLocator(numticks=12))
    axes.yaxis.set_minor_formatter(NullFormatter())
    axes.xaxis.set_major_locator(MaxNLocator(integer=True))
    axes.tick_params(which="minor", length=0)


def _at_end(statistics: Mapping[str, Mapping[str, Any]]) -> float:
    """Where a line ends: the legend stands in the order of the lines."""
    return float(list(statistics.values())[-1]["mean"])
