"""Waves of the residual over the joint's angle."""

from collections.abc import Mapping
from typing import Any

from lagrangian_ff.report.colours import FAINT, MEASURED, RESIDUAL
from lagrangian_ff.report.interactive.plot import Plot, axis, line


def orders_plot(spectrum: Mapping[str, Any]) -> Plot:
    """Draw the amplitude over the order, above the level that chance reaches, and name the lines.

    Args:
        spectrum: one joint's entry of a record of compare.
    """
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
