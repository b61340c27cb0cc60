"""The candidates by the evidence for them, against what the best of many reaches by chance."""

from collections.abc import Mapping, Sequence
from typing import Any

from lagrangian_ff.report.colours import EFFECT, FAINT, MEASURED
from lagrangian_ff.report.interactive.plot import Plot, axis
from lagrangian_ff.report.words import spoken

MOST = 12


def ranking_plot(ranking: Sequence[Mapping[str, Any]]) -> Plot:
    """Draw a bar for each of the first candidates and a mark at its threshold.

    Args:
        ranking: of a record of diagnose, best first.
    """
    shown = list(ranking[:MOST])
    names = [spoken(f"{one['effect']} on {one['joint']}") for one in shown]
    strong = [one["gain"] > one["threshold"] for one in shown]
    limits = [one["threshold"] for one in shown]
    data: list[dict[str, Any]] = [
        {
            "type": "bar", "orientation": "h", "x": [one["gain"] for one in shown], "y": names,
            "marker": {"color": [EFFECT if one else MEASURED for one in strong]},
            "customdata": limits,
            "hovertemplate": "%{y}: gain %{x:.3g}, chance reaches %{customdata:.3g}<extra></extra>",
        },
        {
            "type": "scatter", "mode": "markers", "x": limits, "y": names, "hoverinfo": "skip",
            "marker": {
                "symbol": "line-ns", "size": 16, "color": FAINT,
                "line": {"width": 2, "color": FAINT},
            },
        },
    ]  # fmt: skip
    layout = {
        "xaxis": axis("gain in log evidence", rangemode="tozero"),
        "yaxis": axis(autorange="reversed", showgrid=False),
        "margin": {"l": 150, "r": 14, "t": 10, "b": 44},
        "bargap": 0.35,
    }
    return Plot(data, layout, 80 + 28 * len(shown))
