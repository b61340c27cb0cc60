"""All candidates side by side, and how strong chance alone can look."""

from typing import TYPE_CHECKING, Any

from lagrangian_ff.report import html
from lagrangian_ff.report.colours import EFFECT, FAINT, MEASURED
from lagrangian_ff.report.page import Section
from lagrangian_ff.report.plot import Plot, axis, embed
from lagrangian_ff.words import spoken

if TYPE_CHECKING:
    from lagrangian_ff.diagnosis import Diagnosis, DiagnosisRun

MOST = 12
"""Candidates that are drawn."""


def ranking_section(run: "DiagnosisRun") -> Section | None:
    """Return the candidates of a diagnosis by their gain in evidence."""
    from lagrangian_ff.diagnosis import thresholds

    if not run.diagnosis.ranking:
        return None
    picture = embed(
        ranking_plot(run.diagnosis), "bars of the gain in evidence of the best candidates"
    )
    often = 100.0 * (1.0 - thresholds.USED.level)
    small = html.note(
        "The mark on each bar is what the best of all candidates stays below, when nothing is "
        f"missing in {often:.0f} % of the cases: found by giving the residual of each block a "
        "random sign and searching again. A bar that ends before its mark is no evidence. This is "
        "the first look, when the model still takes for noise what is missing; once the effect is "
        "in and the noise is chosen again, it gains more, as said above."
    )
    return Section(
        "Against the other candidates",
        "Every effect that a motion can show was tried on every joint. The longer the bar, the "
        "more likely it makes the measured torques.",
        picture + small,
    )


def ranking_plot(diagnosis: "Diagnosis") -> Plot:
    """Draw a bar for each of the first candidates and a mark at the threshold of the null."""
    shown, limit = diagnosis.ranking[:MOST], diagnosis.threshold
    names = [spoken(f"{one.name} on {one.joint}") for one in shown]
    gains = [one.log_bayes_factor for one in shown]
    limits = [limit] * len(shown)
    bars = {
        "type": "bar",
        "orientation": "h",
        "x": gains,
        "y": names,
        "marker": {"color": [EFFECT if gain > limit else MEASURED for gain in gains]},
        "customdata": limits,
        "hovertemplate": "%{y}: gain %{x:.3g}, chance reaches %{customdata:.3g}<extra></extra>",
    }
    grey = {"width": 2, "color": FAINT}
    mark = {"symbol": "line-ns", "size": 16, "color": FAINT, "line": grey}
    marks = {"type": "scatter", "mode": "markers", "x": limits, "y": names, "hoverinfo": "skip"}
    data: list[dict[str, Any]] = [bars, {**marks, "marker": mark}]
    layout = {
        "xaxis": axis("gain in log evidence", rangemode="tozero"),
        "yaxis": axis(autorange="reversed", showgrid=False),
        "margin": {"l": 150, "r": 14, "t": 10, "b": 44},
        "bargap": 0.35,
    }
    return Plot(data, layout, 80 + 28 * len(shown))
