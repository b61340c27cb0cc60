"""The error of each block of held-back motion, before and after an effect was added."""

from collections.abc import Mapping, Sequence
from typing import Any

from lagrangian_ff.report.colours import AFTER, BAD, BEFORE
from lagrangian_ff.report.interactive.plot import Plot, axis


def before_after_plot(blocks: Sequence[Mapping[str, Any]]) -> Plot:
    """Draw two dots a block, joined: blue below grey is better, red above it is worse.

    Args:
        blocks: of a finding in a record of diagnose.
    """
    times = [block["time"] for block in blocks]
    joined_x, joined_y = [], []
    for block in blocks:
        joined_x += [block["time"], block["time"], None]
        joined_y += [block["before"], block["after"], None]
    better = [block["after"] <= block["before"] for block in blocks]
    hover = "%{y:.3g} N·m at %{x:.0f} s"
    data: list[dict[str, Any]] = [
        {
            "type": "scatter", "mode": "lines", "x": joined_x, "y": joined_y, "showlegend": False,
            "line": {"color": BEFORE, "width": 2}, "hoverinfo": "skip",
        },
        {
            "type": "scatter", "mode": "markers", "x": times, "name": "before",
            "y": [block["before"] for block in blocks], "marker": {"color": BEFORE, "size": 8},
            "hovertemplate": hover,
        },
        {
            "type": "scatter", "mode": "markers", "x": times, "name": "after",
            "y": [block["after"] for block in blocks], "hovertemplate": hover,
            "marker": {"color": [AFTER if good else BAD for good in better], "size": 9},
        },
    ]  # fmt: skip
    layout = {
        "xaxis": axis("time of the block [s]"),
        "yaxis": axis("RMS error [N·m]", rangemode="tozero"),
        "showlegend": True,
    }
    return Plot(data, layout, 330)
