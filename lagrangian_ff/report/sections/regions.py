"""Where the model fails: the few regions that hold most of the error."""

from collections.abc import Mapping
from typing import Any

from lagrangian_ff.diagnosis.where.orders import NAMED_SHARE
from lagrangian_ff.report import html
from lagrangian_ff.report.interactive import embed
from lagrangian_ff.report.interactive.overview import blocks_plot, dependence_plot
from lagrangian_ff.report.numbers import number, percent
from lagrangian_ff.report.section import Section
from lagrangian_ff.report.words import sentence

LEAD = (
    "Parts of the motion that hold clearly more of a joint's error than of its time. A part is "
    "named only if error spread at random over the motion would hardly ever show one so striking."
)
EVENLY = "No region stands out: the error is spread evenly over the motion."


def regions_section(record: Mapping[str, Any]) -> Section:
    """The regions as bars; joints without one are named.

    Args:
        record: of compare.
    """
    regions, evenly = record["regions"], record["evenly"]
    rows = [
        html.Share(
            region["joint"],
            region["place"],
            (
                (f"{percent(region['share_of_error'])} of its error", region["share_of_error"]),
                (f"{percent(region['share_of_time'])} of the time", region["share_of_time"]),
            ),
        )
        for region in regions
    ]
    told = record["words"][0] if record["too_short"] else EVENLY
    body = html.shares(rows) if rows else html.paragraph(sentence(told))
    if rows and evenly:
        body += html.note(
            f"On {', '.join(evenly)} no region stands out: the error is spread evenly."
        )
    if waves := _waves(record):
        body += html.bullets(waves)
    return Section("Where it fails", LEAD, body)


def _waves(record: Mapping[str, Any]) -> list[str]:
    return [
        f"{one['joint']}: the residual holds a wave over the joint's angle, "
        f"{one['lines'][0]['order']:.3g} to a turn, of {number(one['lines'][0]['amplitude'], 2)} "
        f"N·m ({percent(one['lines'][0]['share'])} of its error)."
        for one in record["spectra"]
        if one["lines"] and one["lines"][0]["share"] >= NAMED_SHARE
    ]


def dependence_section(record: Mapping[str, Any]) -> Section:
    """Maps of what the error depends on and of when it was large.

    Args:
        record: of compare.
    """
    follows = embed(
        dependence_plot(record["bins"]),
        "map of joints and coordinates: the share of the squared error that follows each",
        "How much of each joint's squared error would go if the model had the right function of "
        "this one quantity. What chance alone would give is taken off. A dark field is a lead: an "
        "effect that depends on this quantity is missing or wrong.",
    )
    when = embed(
        blocks_plot(record),
        "map of joints and time: the error of each 3 seconds relative to the joint's usual error",
        "Error of each 3 s relative to the joint's RMS error; pale is none, dark three times the "
        "usual.",
    )
    return Section(
        "What the error follows",
        "Each joint's error, held against everything that is known of the motion.",
        f'{follows}<h3 class="plain">When it was large</h3>{when}',
    )
