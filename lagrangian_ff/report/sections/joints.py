"""Each joint: its torque over time, its residual over every coordinate, the waves in it."""

import math
from typing import TYPE_CHECKING

import numpy as np

from lagrangian_ff.report import html
from lagrangian_ff.report.colours import FAINT, MEASURED, PREDICTED, RESIDUAL, faded
from lagrangian_ff.report.page import Section
from lagrangian_ff.report.plot import Plot, Trace, axis, band, embed, line

if TYPE_CHECKING:
    from lagrangian_ff.arrays import Floats
    from lagrangian_ff.diagnosis import Comparison
    from lagrangian_ff.diagnosis.where import Bins, Localisation, Spectrum

LEAD = (
    "Pick a joint. Drag over a figure to zoom, double-click to see all of it again, hover to read "
    "values."
)
CORNER = {"xref": "container", "x": 0, "xanchor": "left", "y": 1, "yanchor": "top"}
"""The place of a small figure's title."""
NOTE = (
    "Line: the mean residual (measured minus predicted) in bins that hold the same time each; its "
    "band holds the true mean 90 % of the time. Where the band leaves zero, the model is "
    "systematically wrong, not by noise. Bars: the share of the joint's squared error in each bin."
)


def joints_section(where: "Localisation", first: str | None = None) -> Section:
    """Return a panel for each joint; the first shown is `first`, or that of the first region."""
    joints = where.comparison.score.joints
    if first is None and where.regions:
        first = where.regions[0].joint
    panels = [(joint, _panel(where, joint)) for joint in joints]
    shown = joints.index(first) if first in joints else 0
    return Section("Joint by joint", LEAD, html.tabs("joints", panels, shown))


def _panel(where: "Localisation", joint: str) -> str:
    shown = f"torque of {joint} over time: measured, predicted, and what is left"
    torque = embed(torque_plot(where.comparison, joint), shown)
    residuals = [
        embed(residual_plot(one), f"residual of {joint} over {one.coordinate.label}")
        for one in where.bins
        if one.joint == joint
    ]
    orders = [
        embed(
            orders_plot(one),
            f"amplitude of waves of the residual of {joint} over its angle",
            "Waves of the residual over the joint's angle. Lines above the grey are cogging, "
            "torque ripple or gear mesh. Orders closer than "
            f"{one.resolution:.2g} cannot be separated on this motion.",
        )
        for one in where.spectra
        if one.joint == joint
    ]
    return "".join([torque, html.plots(residuals), html.note(NOTE), *orders])


def torque_plot(comparison: "Comparison", joint: str) -> Plot:
    """Draw the torque above and the residual below, over one time.

    The 90 % intervals, if there are any, lie behind the lines as a band around the prediction and,
    below, around zero; one entry of the legend switches both.
    """
    n, at, interval = comparison.motion.joints.index(joint), comparison.shown, comparison.interval
    breaks = np.flatnonzero(np.diff(comparison.motion.segment[at])) + 1

    def broken(values: "Floats") -> list[float | None]:
        """Return the values with a break at each interruption of the recording."""
        found = np.insert(values, breaks, np.nan).tolist()
        return [None if math.isnan(one) else one for one in found]

    measured, predicted = comparison.motion.tau[at, n], comparison.predicted[at, n]
    time = broken(comparison.motion.elapsed[at])
    data = []
    if interval:
        reach, common = interval.reach[:, n], {"name": "90 % interval", "legendgroup": "interval"}
        data = [
            band(time, broken(middle - reach), broken(middle + reach), PREDICTED, **common, **place)
            for middle, place in (
                (predicted, {"showlegend": True}),
                (np.zeros_like(reach), {"yaxis": "y2"}),
            )
        ]
    left = broken(measured - predicted)
    data += [
        line(time, broken(measured), "measured", MEASURED, width=2.4),
        line(time, broken(predicted), "predicted", PREDICTED, width=1.2),
        line(time, left, "measured − predicted", RESIDUAL, width=1.2, yaxis="y2"),
    ]
    layout = {
        "xaxis": axis("time [s]", anchor="y2"),
        "yaxis": axis("torque [N·m]", domain=[0.42, 1.0]),
        "yaxis2": axis("left [N·m]", domain=[0.0, 0.34]),
        "hovermode": "x unified",
        "showlegend": True,
    }
    return Plot(data, layout, 400)


def residual_plot(bins: "Bins") -> Plot:
    """Draw the mean residual with its band, and below it the share of the error in each bin."""
    coordinate, label, mean = bins.coordinate, bins.coordinate.label, bins.mean.tolist()
    hover = "%{y:.0f} % of the error<br>%{customdata:.0f} % of the time<extra></extra>"
    bars: Trace = {"type": "bar", "name": "share of the error", "yaxis": "y2"}
    bars |= {"marker": {"color": faded(RESIDUAL, 0.55)}, "hovertemplate": hover}
    bars["y"] = (100.0 * bins.share_of_error).tolist()
    bars["customdata"] = (100.0 * bins.share_of_time).tolist()
    if coordinate.levels:
        names = [coordinate.levels[value] for value in bins.low]
        up, down = (bins.mean_high - bins.mean).tolist(), (bins.mean - bins.mean_low).tolist()
        error = {"type": "data", "symmetric": False, "array": up, "arrayminus": down}
        points: Trace = {"type": "scatter", "mode": "markers", "x": names, "y": mean}
        points["marker"] = {"color": RESIDUAL, "size": 9}
        points["error_y"] = {**error, "color": RESIDUAL, "thickness": 1.5}
        points["hovertemplate"] = "%{y:.3g} N·m<extra></extra>"
        data = [points, {**bars, "x": names, "width": 0.5}]
        horizontal = axis(anchor="y2", type="category")
    else:
        places = (0.5 * (bins.low + bins.high)).tolist()
        marker = {**bars["marker"], "line": {"color": "#ffffff", "width": 0.5}}
        style = {"width": 2, "mode": "lines+markers", "marker": {"size": 5}}
        hover = "%{x:.3g}: %{y:.3g} N·m<extra></extra>"
        data = [
            band(places, bins.mean_low.tolist(), bins.mean_high.tolist(), RESIDUAL),
            line(places, mean, "mean residual", RESIDUAL, **style, hovertemplate=hover),
            {**bars, "x": places, "width": (bins.high - bins.low).tolist(), "marker": marker},
        ]
        unit = f" [{coordinate.unit}]" if coordinate.unit else ""
        horizontal = axis(f"{label}{unit}", anchor="y2")
    layout = {
        "title": {"text": label, "font": {"size": 13}, "pad": {"l": 8, "t": 4}, **CORNER},
        "xaxis": horizontal,
        "yaxis": axis("mean residual [N·m]", domain=[0.4, 1.0], zeroline=True, zerolinecolor=FAINT),
        "yaxis2": axis("% of error", domain=[0.0, 0.28], rangemode="tozero", nticks=3),
        "bargap": 0,
    }
    return Plot(data, layout, 330)


def orders_plot(spectrum: "Spectrum") -> Plot:
    """Draw the amplitude over the order above the level that chance reaches; name the lines."""
    order = spectrum.order.tolist()
    grey = {"fill": "tozeroy", "fillcolor": "rgba(154,165,177,0.22)", "hoverinfo": "skip"}
    chance, hover = "what chance reaches (95 %)", "order %{x:.4g}: %{y:.3g} N·m<extra></extra>"
    noise = line(order, spectrum.noise.tolist(), chance, MEASURED, width=1, **grey)
    found, name = spectrum.amplitude.tolist(), "amplitude of the residual"
    measured = line(order, found, name, RESIDUAL, width=1.4, hovertemplate=hover)
    arrow = {"showarrow": True, "arrowhead": 0, "arrowcolor": FAINT, "ax": 0, "ay": -18}
    style = {**arrow, "font": {"size": 11}}
    names = [
        {"x": one.order, "y": one.amplitude, "text": f"{one.order:.3g}", **style}
        for one in spectrum.lines
    ]
    layout = {
        "xaxis": axis("waves in one turn of the joint", range=[0, order[-1]]),
        "yaxis": axis("amplitude [N·m]", rangemode="tozero"),
        "annotations": names,
        "showlegend": True,
    }
    return Plot([noise, measured], layout, 280)
