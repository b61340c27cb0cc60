"""Figures that can be zoomed, hovered and switched, drawn by plotly.js in the reader's browser.

A section makes a `Plot` (what plotly.js draws, as plain data) and puts it in its text with `embed`.
plotly.js, its cartesian bundle (npm: plotly.js-cartesian-dist-min 4.1.1), lies beside this file as
gzip packed it. A page holds it once, and works without a network; the library and the figures' data
stay packed in it, which makes them a third of their size.
"""

import base64
import gzip
import json
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from importlib.resources import files
from itertools import pairwise
from typing import Any

from lagrangian_ff.report.colours import FAINT, FRAME, GRID, INK, faded
from lagrangian_ff.report.html import escape

Trace = dict[str, Any]
LINES = {"type": "scatter", "mode": "lines"}

MARK = 'class="plot"'
"""A page that holds this needs the library."""
LIBRARY = "plotly-cartesian.min.js.gz"
FONT = 'Inter, "Segoe UI", "Helvetica Neue", Roboto, "DejaVu Sans", system-ui, sans-serif'
ABOVE = {"x": 0, "y": 1.02, "xanchor": "left", "yanchor": "bottom"}
DIGITS = 5
"""Significant digits of every number in a page: finer than any pixel, and half the size."""


@dataclass(frozen=True)
class Plot:
    """One figure as plotly.js takes it.

    Attributes:
        data: the traces.
        layout: what differs from the common layout.
        height: pixels.
    """

    data: Sequence[Trace]
    layout: Mapping[str, Any] = field(default_factory=dict)
    height: int = 300

    def full_layout(self) -> dict[str, Any]:
        """Return the common layout with what differs."""
        common = {
            "font": {"family": FONT, "size": 12, "color": INK},
            "margin": {"l": 58, "r": 14, "t": 28, "b": 44},
            "paper_bgcolor": "rgba(0,0,0,0)",
            "plot_bgcolor": "rgba(0,0,0,0)",
            "hovermode": "closest",
            "hoverlabel": {"bgcolor": "#ffffff", "bordercolor": FRAME, "font": {"color": INK}},
            "legend": {"orientation": "h", **ABOVE, "font": {"size": 11}},
            "modebar": {"bgcolor": "rgba(255,255,255,0.8)", "color": FRAME, "activecolor": FAINT},
            "showlegend": False,
            "height": self.height,
            "autosize": True,
        }
        return {**common, **self.layout}


def axis(title: str = "", **more: Any) -> dict[str, Any]:
    """Return an axis in the common style."""
    return {
        "title": {"text": title, "font": {"size": 11.5, "color": FAINT}, "standoff": 8},
        "gridcolor": GRID,
        "zerolinecolor": FRAME,
        "linecolor": FRAME,
        "tickfont": {"size": 11, "color": FAINT},
        "automargin": True,
        **more,
    }


def line(
    x: Sequence[float | None], y: Sequence[float | None], name: str, colour: str, **more: Any
) -> Trace:
    """Return a line; None and NaN break it."""
    style = {"color": colour, "width": more.pop("width", 1.6)}
    return {**LINES, "x": list(x), "y": list(y), "name": name, "line": style, **more}


def band(
    x: Sequence[float | None],
    low: Sequence[float | None],
    high: Sequence[float | None],
    colour: str,
    **more: Any,
) -> Trace:
    """Return the area between two lines, without a place in the legend; None breaks it."""
    around: list[float | None] = []
    level: list[float | None] = []
    for part in _pieces(x):
        around += [*([None] if around else []), *x[part], *reversed(x[part])]
        level += [*([None] if level else []), *high[part], *reversed(low[part])]
    area = {"fill": "toself", "fillcolor": faded(colour, 0.16), "line": {"width": 0}}
    quiet = {"hoverinfo": "skip", "showlegend": False}
    return {**LINES, "x": around, "y": level, **area, **quiet, **more}


def _pieces(x: Sequence[float | None]) -> Iterator[slice]:
    """Yield the stretches between one None and the next."""
    cuts = [-1, *(k for k, value in enumerate(x) if value is None), len(x)]
    for before, after in pairwise(cuts):
        if after > before + 1:
            yield slice(before + 1, after)


def embed(plot: Plot, alternative: str, caption: str = "") -> str:
    """Return a figure as a piece of a page, with an alternative for readers who cannot see it."""
    drawn = {"data": _plain(plot.data), "layout": _plain(plot.full_layout())}
    data = json.dumps(drawn, ensure_ascii=False, separators=(",", ":"), allow_nan=False)
    below = f"<figcaption>{escape(caption)}</figcaption>" if caption else ""
    return (
        f'<figure><div {MARK} role="img" aria-label="{escape(alternative)}" '
        f'style="height:{plot.height}px"></div>'
        f'<script type="text/plain">{_packed(data)}</script>{below}</figure>'
    )


def _plain(value: Any) -> Any:
    """Return plain JSON data with rounded numbers; NaN and infinities become null."""
    if isinstance(value, Mapping):
        return {str(key): _plain(inner) for key, inner in value.items()}
    if isinstance(value, (list, tuple)):
        return [_plain(inner) for inner in value]
    if isinstance(value, float):
        if not math.isfinite(value):
            return None
        short = float(f"{value:.{DIGITS}g}")
        if math.isinf(short):  # the largest numbers of all, rounded up
            return value
        return int(short) if short.is_integer() and abs(short) < 1e6 else short
    return value


def scripts() -> str:
    """Return plotly.js and what unpacks and starts it, as script elements."""
    here = files(__package__)
    library = base64.b64encode(here.joinpath(LIBRARY).read_bytes()).decode("ascii")
    start = here.joinpath("start.js").read_text(encoding="utf-8")
    return (
        f'<script type="text/plain" id="library">{library}</script>\n<script>\n{start}</script>\n'
    )


def _packed(text: str) -> str:
    return base64.b64encode(gzip.compress(text.encode(), mtime=0)).decode("ascii")
