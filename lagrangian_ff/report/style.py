"""The common style of pictures drawn by matplotlib: a quiet frame, PNG as bytes."""

import io
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import Any

import numpy as np
from matplotlib import rc_context
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.layout_engine import ConstrainedLayoutEngine

from lagrangian_ff.arrays import Floats, Ints
from lagrangian_ff.report.colours import FAINT, FRAME, GRID, INK

WIDTH = 10.0  # inches
DPI = 150
LEGEND_STRIP = 0.3  # inches
MOST_POINTS = 3000
"""A line of more points is thinned: no eye and no pixel can separate them."""

_RC: dict[Any, Any] = {
    "font.family": "sans-serif",
    "font.size": 9.0,
    "text.color": INK,
    "axes.labelcolor": INK,
    "axes.edgecolor": FRAME,
    "axes.linewidth": 0.8,
    "axes.titlesize": 9.5,
    "axes.titleweight": "bold",
    "axes.titlelocation": "left",
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "axes.axisbelow": True,
    "grid.color": GRID,
    "grid.linewidth": 0.7,
    "xtick.color": FAINT,
    "ytick.color": FAINT,
    "xtick.labelsize": 8.0,
    "ytick.labelsize": 8.0,
    "xtick.major.size": 0.0,
    "ytick.major.size": 0.0,
    "legend.frameon": False,
    "lines.linewidth": 1.1,
    "figure.facecolor": "white",
}


@contextmanager
def styled() -> Iterator[None]:
    """Draw in the common style; the user's own settings of matplotlib are left alone."""
    with rc_context(_RC):
        yield


def new_figure(height: float) -> Figure:
    """Return an empty figure of the common width, `height` in inches, with room for labels."""
    figure = Figure(figsize=(WIDTH, height), dpi=DPI, layout="constrained")
    FigureCanvasAgg(figure)
    return figure


def legend_above(figure: Figure, handles: Sequence[Artist], labels: Sequence[str]) -> None:
    """Put one line of legend above all panels, in a strip that the layout keeps free."""
    free = LEGEND_STRIP / float(figure.get_size_inches()[1])
    engine = figure.get_layout_engine()
    assert isinstance(engine, ConstrainedLayoutEngine)
    engine.set(rect=(0.0, 0.0, 1.0, 1.0 - free))
    figure.legend(handles, labels, loc="upper left", ncol=len(labels))


def png(figure: Figure) -> bytes:
    """Return the figure as the bytes of a PNG file."""
    buffer = io.BytesIO()
    with styled():
        figure.savefig(buffer, format="png")
    return buffer.getvalue()


def thinned(time: Floats, *columns: Floats) -> tuple[Floats, ...]:
    """Return at most `MOST_POINTS` of the samples, the last one among them."""
    index = np.arange(len(time))
    if len(time) > MOST_POINTS:
        index = np.round(np.linspace(0, len(time) - 1, MOST_POINTS)).astype(np.int64)
    return (time[index], *(column[index] for column in columns))


def broken(time: Floats, segment: Ints, values: Floats) -> tuple[Floats, Floats]:
    """Return time and values with NaN between segments, so that no line crosses a gap."""
    cuts = np.flatnonzero(np.diff(segment)) + 1
    return np.insert(time, cuts, np.nan), np.insert(values, cuts, np.nan)


def symmetric(axes: Axes, largest: float) -> None:
    """Put zero in the middle, and show everything up to `largest`."""
    reach = 1.08 * largest if largest > 0.0 else 1.0
    axes.set_ylim(-reach, reach)
