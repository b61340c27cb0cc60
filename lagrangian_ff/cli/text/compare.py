"""Where a model fails, as text."""

from collections.abc import Mapping
from typing import Any

from lagrangian_ff.cli.common.console import Console

MOST = 8
"""Regions told; the rest is in the record."""


def say_where(record: Mapping[str, Any], console: Console) -> None:
    """The regions that hold most of the error, in words.

    Args:
        record: of compare.
        console: to tell it to.
    """
    regions, evenly = record["regions"], record["evenly"]
    console.say("where it fails")
    if record["too_short"]:
        console.paragraph(record["words"][0], "  ", "    ")
    for region in regions[:MOST]:
        console.paragraph(region["words"], "  ", "    ")
    if len(regions) > MOST:
        console.say(f"  and {len(regions) - MOST} more")
    for text in waves(record):
        console.paragraph(text, "  ", "    ")
    if evenly and regions:
        console.paragraph(f"{', '.join(evenly)}: the error is spread evenly", "  ", "    ")
    elif evenly:
        console.say("  nowhere in particular: the error is spread evenly over the motion")


def waves(record: Mapping[str, Any]) -> list[str]:
    """The strongest wave over each joint's angle, where one stands out."""
    return [
        f"{one['joint']}: a wave of {one['lines'][0]['amplitude']:.2g} N·m over its angle, "
        f"{one['lines'][0]['order']:.3g} to a turn"
        for one in record["spectra"]
        if one["lines"]
    ]


def next_step(record: Mapping[str, Any]) -> list[str]:
    """The command that asks what is missing."""
    sources = " ".join(map(str, record["sources"]))
    return [
        "next: which physical effect is missing?",
        f"  lagrangian_ff diagnose {record['model']} {sources}",
    ]
