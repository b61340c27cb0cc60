"""Each joint: its torque over time, its residual over every coordinate, the waves in it."""

from collections.abc import Mapping, Sequence
from typing import Any

from lagrangian_ff.report import html
from lagrangian_ff.report.colours import FAINT, MEASURED, PREDICTED, RESIDUAL, faded
from lagrangian_ff.report.page import Section
from lagrangian_ff.report.plot import Plot, Trace, axis, band, embed, line

Values = list[float | None]

WORDS = {
    "direction": {-1.0: "backwards", 1.0: "forwards"},
    "outside_range": {0.0: "inside", 1.0: "outside"},
}
LEAD = (
    "Pick a joint. Drag over a figure to zoom, double-click to see all of it again, hover to read "
    "values."
)
NOTE = (
    "Line: the mean residual (measured minus predicted) in bins that hold the same time each; its "
    "band holds the true mean 90 % of the time. Where the band leaves zero, the model is "
    "systematically wrong, not by noise. Bars: the share of the joint's squared error in each bin."
)


def joints_section(record: Mapping[str, Any], first: str | None = None) -> Section:
    """Return a panel for each joint.

    Args:
        record: of a comparison, with the series.
        first: the joint shown first; None takes that of the first region.
    """
    joints = list(record["joints"])
    if first is None and record["regions"]:
        first = record["regions"][0]["joint"]
    panels = [(joint, _panel(record, joint)) for joint in joints]
    shown = joints.index(first) if first in joints else 0
    return Section("Joint by joint", LEAD, html.tabs("joints", panels, shown))


def _panel(record: Mapping[str, Any], joint: str) -> str:
    parts = []
    if "series" in record:
        shown = f"torque of {joint} over time: measured, predicted, and what is left"
        parts.append(embed(torque_plot(record["series"], joint), shown))
    residuals = [
        embed(residual_plot(one), f"residual of {joint} over {one['label']}")
        for one in record["bins"]
        if one["joint"] == joint
    ]
    parts += [html.plots(residuals), html.note(NOTE)]
    parts += [
        embed(
            orders_plot(one),
            f"amplitude of waves of the residual of {joint} over its angle",
            "Waves of the residual over the joint's angle. Lines above the grey are cogging, "
            "torque ripple or gear mesh. Orders closer than "
            f"{one['resolution']:.2g} cannot be separated on this motion.",
        )
        for one in record["spectra"]
        if one["joint"] == joint
    ]
    return "".join(parts)


def torque_plot(series: Mapping[str, Any], joint: str) -> Plot:
    """Draw the torque above and the residual below, over one time.

    If the series has the reach of the 90 % intervals, they lie behind the lines as a band around
    the prediction and, below, around zero.
    """
    values = series["joints"][joint]
    reached = values.get("reach")
    time, measured, predicted, *reach = _broken(
        series["segment"],
        [series["time"], values["measured"], values["predicted"], *([reached] if reached else [])],
    )
    data = [
        *(_bands(time, predicted, reach[0]) if reach else ()),
        line(time, measured, "measured", MEASURED, width=2.4),
        line(time, predicted, "predicted", PREDICTED, width=1.2),
        line(time, _sum(measured, predicted, -1.0), "measured − predicted", RESIDUAL, width=1.2,
             yaxis="y2"),
    ]  # fmt: skip
    layout = {
        "xaxis": axis("time [s]", anchor="y2"),
        "yaxis": axis("torque [N·m]", domain=[0.42, 1.0]),
        "yaxis2": axis("left [N·m]", domain=[0.0, 0.34]),
        "hovermode": "x unified",
        "showlegend": True,
    }
    return Plot(data, layout, 400)


def _bands(time: Values, predicted: Values, reach: Values) -> list[Trace]:
    """Return bands around prediction and zero; one entry of the legend switches both."""
    zero: Values = [None if one is None else 0.0 for one in reach]
    common = {"name": "90 % interval", "legendgroup": "interval"}
    return [
        band(time, _sum(middle, reach, -1.0), _sum(middle, reach, 1.0), PREDICTED,
             **common, **place)
        for middle, place in ((predicted, {"showlegend": True}), (zero, {"yaxis": "y2"}))
    ]  # fmt: skip


def _sum(one: Values, other: Values, sign: float) -> Values:
    """Return one plus or minus the other; None if either is unknown."""
    return [
        None if a is None or b is None else a + sign * b for a, b in zip(one, other, strict=True)
    ]


def _broken(segments: Sequence[int], columns: Sequence[Sequence[float | None]]) -> list[Values]:
    """Return the columns with a break at each interruption of the recording."""
    out: list[Values] = [[] for _ in columns]
    before = None
    for segment, *row in zip(segments, *columns, strict=True):
        if before is not None and segment != before:
            for column in out:
                column.append(None)
        before = segment
        for column, value in zip(out, row, strict=True):
            column.append(value)
    return out


def residual_plot(bins: Mapping[str, Any]) -> Plot:
    """Draw the mean residual with its band, and below it the share of the error in each bin."""
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


def orders_plot(spectrum: Mapping[str, Any]) -> Plot:
    """Draw the amplitude over the order above the level that chance reaches; name the lines."""
    order = spectrum["order"]
    noise = line(
        order, spectrum["noise"], "what chance reaches (95 %)", MEASURED, width=1,
        fill="tozeroy", fillcolor="rgba(154,165,177,0.22)", hoverinfo="skip",
    )  # fmt: skip
    measured = line(
        order, spectrum["amplitude"], "amplitude of the residual", RESIDUAL, width=1.4,
        hovertemplate="order %{x:.4g}: %{y:.3g} N·m<extra></extra>",
    )  # fmt: skip
    names = [
        {
            "x": one["order"], "y": one["amplitude"], "text": f"{one['order']:.3g}",
            "showarrow": True, "arrowhead": 0, "arrowcolor": FAINT, "ax": 0, "ay": -18,
            "font": {"size": 11},
        }
        for one in spectrum["lines"]
    ]  # fmt: skip
    layout = {
        "xaxis": axis("waves in one turn of the joint", range=[0, order[-1]]),
        "yaxis": axis("amplitude [N·m]", rangemode="tozero"),
        "annotations": names,
        "showlegend": True,
    }
    return Plot([noise, measured], layout, 280)
