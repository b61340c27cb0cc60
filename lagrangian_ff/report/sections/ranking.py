"""All candidates side by side, and how strong chance alone can look."""

from collections.abc import Mapping
from typing import Any

from lagrangian_ff.report import html
from lagrangian_ff.report.interactive import embed
from lagrangian_ff.report.interactive.ranking import ranking_plot
from lagrangian_ff.report.section import Section


def ranking_section(record: Mapping[str, Any]) -> Section | None:
    """The candidates by their gain in evidence.

    Args:
        record: of diagnose.
    """
    if not record.get("ranking"):
        return None
    picture = embed(
        ranking_plot(record["ranking"]), "bars of the gain in evidence of the best candidates"
    )
    level = (record.get("null") or {}).get("level")
    often = f" in {100.0 * level:.0f} % of the cases" if level else ""
    small = html.note(
        "The mark on each bar is what the best of all candidates stays below, when nothing is "
        f"missing{often}: found by giving the residual of each block a random sign and searching "
        "again. A bar that ends before its mark is no evidence. This is the first look, when the "
        "model still takes for noise what is missing; once the effect is in and the noise is "
        "chosen anew, it gains more, as told above."
    )
    return Section(
        "Against the other candidates",
        "Every effect that a motion can show was tried on every joint. The longer the bar, the "
        "more likely it makes the measured torques.",
        picture + small,
    )
