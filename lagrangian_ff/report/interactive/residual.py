"""The mean residual over one coordinate, and where its error lies."""

from collections.abc import Mapping
from typing import Any

from lagrangian_ff.report.colours import FAINT, RESIDUAL, faded
from lagrangian_ff.report.interactive.plot import Plot, axis, band, line

WORDS = {
    "direction": {-1.0: "backwards", 1.0: "forwards"},
    "outside_range": {0.0: "inside", 1.0: "outside"},
}


def residual_plot(bins: Mapping[str, Any]) -> Plot:
    """Draw the mean residual with its band, and below it the share of the error in each bin.

    Args:
        bins: one joint's entry of a record of compare.
    """
    levels = WORDS.get(bins["coordinate"])
    bars: dict[str, Any] = {
        "type": "bar", "name": "share of the error", "yaxis": "y2",
        "y": [100.0 * share for share in bins["share_of_error"]],
        "marker": {"color": faded(RESIDUAL, 0.55)},
        "customdata": [100.0 * share for share in bins["share_of_time"]],
        "hovertemplate": "%{y:.0f} % of the error<br>%{customdata:.0f} % of the time"
        "<extra></extra>",
    }  # fmt: skip
    if levels:
        places: list[Any] = [levels[value] for value in bins["low"]]
        points = {
            "type": "scatter", "mode": "markers", "x": places, "y": bins["mean"],
            "marker": {"color": RESIDUAL, "size": 9},
            "error_y": {
                "type": "data", "symmetric": False, "color": RESIDUAL, "thickness": 1.5,
                "array": [h - m for h, m in zip(bins["mean_high"], bins["mean"], strict=True)],
                "arrayminus": [m - v for m, v in zip(bins["mean"], bins["mean_low"], strict=True)],
            },
            "hovertemplate": "%{y:.3g} N·m<extra></extra>",
        }  # fmt: skip
        data = [points, {**bars, "x": places, "width": 0.5}]
        horizontal = axis(anchor="y2", type="category")
    else:
        places = [0.5 * (a + b) for a, b in zip(bins["low"], bins["high"], strict=True)]
        widths = [b - a for a, b in zip(bins["low"], bins["high"], strict=True)]
        curve = line(
            places, bins["mean"], "mean residual", RESIDUAL, width=2, mode="lines+markers",
            marker={"size": 5}, hovertemplate="%{x:.3g}: %{y:.3g} N·m<extra></extra>",
        )  # fmt: skip
        data = [
            band(places, bins["mean_low"], bins["mean_high"], RESIDUAL),
            curve,
            {**bars, "x": places, "width": widths, "marker": {
                **bars["marker"], "line": {"color": "#ffffff", "width": 0.5}}},
        ]  # fmt: skip
        unit = f" [{bins['unit']}]" if bins["unit"] else ""
        horizontal = axis(f"{bins['label']}{unit}", anchor="y2")
    layout = {
        "title": {
            "text": bins["label"], "x": 0, "xref": "container", "xanchor": "left",
            "font": {"size": 13}, "pad": {"l": 8, "t": 4}, "y": 1, "yanchor": "top",
        },
        "xaxis": horizontal,
        "yaxis": axis("mean residual [N·m]", domain=[0.4, 1.0], zeroline=True, zerolinecolor=FAINT),
        "yaxis2": axis("% of error", domain=[0.0, 0.28], rangemode="tozero", nticks=3),
        "bargap": 0,
    }  # fmt: skip
    return Plot(data, layout, 330)
