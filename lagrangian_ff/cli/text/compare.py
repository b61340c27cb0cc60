"""Where a model fails, as text."""

from collections.abc import Mapping
from typing import Any

from lagrangian_ff.cli.common.console import Console

MOST = 12
"""Sentences told; the rest is in the record."""
NOWHERE = "nowhere in particular: the error is spread evenly over the motion"


def say_where(record: Mapping[str, Any], console: Console) -> None:
    """The regions that hold most of the error, in words.

    Args:
        record: of compare.
        console: to tell it to.
    """
    words = record["words"]
    if len(record["evenly"]) == len(record["joints"]) and len(words) == 1:
        words = [NOWHERE]
    console.say("where it fails")
    for text in words[:MOST]:
        console.paragraph(text, "  ", "    ")
    if len(words) > MOST:
        console.say(f"  and {len(words) - MOST} more places, see --report or --json")


def next_step(record: Mapping[str, Any]) -> list[str]:
    """The command that asks what is missing."""
    sources = " ".join(map(str, record["sources"]))
    return [
        "next: which physical effect is missing?",
        f"  lagrangian_ff diagnose {record['model']} {sources}",
    ]
