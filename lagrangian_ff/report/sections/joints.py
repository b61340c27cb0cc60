"""Everything about each joint: its torque over time, its residual over every coordinate."""

from collections.abc import Mapping, Sequence
from typing import Any

from lagrangian_ff.report import html
from lagrangian_ff.report.interactive import embed
from lagrangian_ff.report.interactive.orders import orders_plot
from lagrangian_ff.report.interactive.residual import residual_plot
from lagrangian_ff.report.interactive.torque import torque_plot
from lagrangian_ff.report.section import Section

LEAD = (
    "Pick a joint. Drag over a figure to zoom, double-click to see all of it again, hover to read "
    "values."
)


def joints_section(record: Mapping[str, Any], first: str | None = None) -> Section:
    """A panel for each joint.

    Args:
        record: of compare, with the series.
        first: the joint shown first; None takes that of the first region.
    """
    joints = list(record["joints"])
    if first is None and record["regions"]:
        first = record["regions"][0]["joint"]
    panels = [(joint, _panel(record, joint)) for joint in joints]
    return Section(
        "Joint by joint",
        LEAD,
        html.tabs("joints", panels, joints.index(first) if first in joints else 0),
    )


def _panel(record: Mapping[str, Any], joint: str) -> str:
    parts = []
    if "series" in record:
        parts.append(
            embed(
                torque_plot(record["series"], joint),
                f"torque of {joint} over time: measured, predicted, and what is left",
            )
        )
    mine = [one for one in record["bins"] if one["joint"] == joint]
    parts.append(html.plots(_residual(one) for one in mine))
    parts.append(
        html.note(
            "Line: the mean residual (measured minus predicted) in bins that hold the same time "
            "each; its band holds the true mean 90 % of the time. Where the band leaves zero, the "
            "model is systematically wrong, not by noise. Bars: the share of the joint's squared "
            "error in each bin."
        )
    )
    parts += [_spectrum(one) for one in _of(record["spectra"], joint)]
    return "".join(parts)


def _residual(bins: Mapping[str, Any]) -> str:
    return embed(residual_plot(bins), f"residual of {bins['joint']} over {bins['label']}")


def _spectrum(spectrum: Mapping[str, Any]) -> str:
    return embed(
        orders_plot(spectrum),
        f"amplitude of waves of the residual of {spectrum['joint']} over its angle",
        "Waves of the residual over the joint's angle. Lines above the grey are cogging, torque "
        f"ripple or gear mesh. Orders closer than {spectrum['resolution']:.2g} cannot be told "
        "apart on this motion.",
    )


def _of(entries: Sequence[Mapping[str, Any]], joint: str) -> list[Mapping[str, Any]]:
    return [one for one in entries if one["joint"] == joint]
