"""All candidates side by side, and how strong chance alone can look."""

from collections.abc import Mapping, Sequence
from typing import Any

from lagrangian_ff.report import html
from lagrangian_ff.report.colours import EFFECT, FAINT, MEASURED
from lagrangian_ff.report.page import Section
from lagrangian_ff.report.plot import Plot, axis, embed
from lagrangian_ff.words import spoken

MOST = 12
"""Candidates that are drawn."""


def ranking_section(record: Mapping[str, Any]) -> Section | None:
    """Return the candidates of a diagnosis by their gain in evidence."""
    if not record.get("ranking"):
        return None
    picture = embed(
        ranking_plot(record["ranking"]), "bars of the gain in evidence of the best candidates"
    )
    level = (record.get("null") or {}).get("level")
    often = f" in {100.0 * (1.0 - level):.0f} % of the cases" if level else ""
    small = html.note(
        "The mark on each bar is what the best of all candidates stays below, when nothing is "
        f"missing{often}: found by giving the residual of each block a random sign and searching "
        "again. A bar that ends before its mark is no evidence. This is the first look, when the "
        "model still takes for noise what is missing; once the effect is in and the noise is "
        "chosen again, it gains more, as said above."
    )
    return Section(
        "Against the other candidates",
        "Every effect that a motion can show was tried on every joint. The longer the bar, the "
        "more likely it makes the measured torques.",
        picture + small,
    )


def ranking_plot(ranking: Sequence[Mapping[str, Any]]) -> Plot:
    """Draw a bar for each of the first candidates and a mark at its threshold."""
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
