"""The study in one picture: outcomes by size, by effect, and what adding is worth."""

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from lagrangian_ff.report.style import FAINT, INK, new_figure, styled

COLOURS = {
    "right": "#2b8a3e",
    "class": "#8ce99a",
    "part": "#74c0fc",
    "wrong": "#c92a2a",
    "nothing": "#dee2e6",
}
WORDS = {
    "right": "right",
    "class": "right, as a class",
    "part": "one of two",
    "wrong": "wrong",
    "nothing": "nothing confirmed",
}

LEAST, MOST = 0.8, 3.0
"""Ratios of errors beyond these are drawn at the edge."""


def figure(numbers: dict[str, Any]) -> Figure:
    """Draw the summary.

    Args:
        numbers: see `summary`.
    """
    with styled():
        drawn = new_figure(2.9 + 0.24 * max(len(numbers["effects"]), 6))
        grid = drawn.add_gridspec(2, 2, width_ratios=(1.0, 1.1), height_ratios=(1.0, 0.9))
        _bars(drawn.add_subplot(grid[0, 0]), numbers)
        _ratios(drawn.add_subplot(grid[1, 0]), numbers["ratio"])
        _effects(drawn.add_subplot(grid[:, 1]), numbers["effects"])
        patches = [Patch(color=COLOURS[name], label=WORDS[name]) for name in COLOURS]
        drawn.legend(handles=patches, loc="outside lower center", ncol=len(patches))
    return drawn


def _bars(axes: Axes, numbers: dict[str, Any]) -> None:
    bars: list[tuple[str, dict[str, int]]] = [
        (f"{100 * float(size):g} %", row) for size, row in numbers["sizes"].items()
    ]
    bars += [(f"two,\n{100 * float(size):g} %", row) for size, row in numbers["pairs"].items()]
    for name, key in (("none", "clean"), ("outside", "outside")):
        row = numbers[key]
        if row["cases"]:
            quiet = row["cases"] - row["wrong"]
            bars.append((name, {"wrong": row["wrong"], "nothing": quiet, "cases": row["cases"]}))
    for place, (_, row) in enumerate(bars):
        below = 0.0
        for name, colour in COLOURS.items():
            share = row.get(name, 0) / row["cases"]
            axes.bar(place, share, 0.72, bottom=below, color=colour)
            if share > 0.06:
                shade = "white" if name in ("right", "wrong") else INK
                axes.text(place, below + 0.5 * share, f"{share:.2f}", color=shade, ha="center",
                          va="center", fontsize=7)  # fmt: skip
            below += share
        axes.text(place, 1.01, f"{row['cases']}", ha="center", fontsize=7, color=FAINT)
    axes.set_xticks(range(len(bars)), [name for name, _ in bars])
    axes.set_ylim(0.0, 1.06)
    axes.grid(visible=False, axis="x")
    axes.set_ylabel("share of cases")
    axes.set_title("What is said, by size of the hidden effect")


def _effects(axes: Axes, effects: dict[str, Any]) -> None:
    sizes = sorted({size for row in effects.values() for size in row}, key=float)
    for y, row in enumerate(effects.values()):
        for x, size in enumerate(sizes):
            if size not in row:
                continue
            counts, left = row[size], x - 0.46
            for name, colour in COLOURS.items():
                width = 0.92 * counts[name] / counts["cases"]
                axes.barh(y, width, 0.8, left=left, color=colour)
                left += width
    axes.set_xticks(range(len(sizes)), [f"{100 * float(size):g} %" for size in sizes])
    axes.set_yticks(range(len(effects)), list(effects))
    axes.set_xlim(-0.5, max(len(sizes), 1) - 0.5)
    axes.set_ylim(max(len(effects), 1) - 0.5, -0.5)
    axes.grid(visible=False)
    axes.set_title("By effect; each cell shows its cases")


def _ratios(axes: Axes, ratios: dict[str, dict[str, Any]]) -> None:
    random = np.random.default_rng(0)
    for place, row in enumerate(ratios.values()):
        values = row.get("each", [])
        spread = place + random.uniform(-0.22, 0.22, size=len(values))
        axes.plot(spread, np.clip(values, LEAST, MOST), "o", color=to_rgb("#1864ab"), alpha=0.45,
                  markersize=3.5, markeredgewidth=0)  # fmt: skip
        if values:
            axes.plot([place - 0.3, place + 0.3], [np.median(values)] * 2, color=INK)
    axes.axhline(1.1, color=COLOURS["wrong"], linewidth=0.8, linestyle=(0, (4, 3)))
    axes.set_yscale("log")
    axes.set_yticks([0.8, 1.0, 1.2, 1.5, 2.0, 3.0], ["0.8", "1", "1.2", "1.5", "2", "3"])
    axes.minorticks_off()
    axes.set_ylim(0.95 * LEAST, 1.05 * MOST)
    axes.set_xticks(range(len(ratios)), [f"{100 * float(size):g} %" for size in ratios])
    axes.set_xlim(-0.5, max(len(ratios), 1) - 0.5)
    axes.grid(visible=False, axis="x")
    axes.set_ylabel("error ratio")
    axes.set_title("Error after adding over that of the true structure")
