"""The page of history: how a model came to be what it is."""

from collections.abc import Mapping
from os import PathLike
from pathlib import Path
from typing import Any

from lagrangian_ff import __version__
from lagrangian_ff.report.numbers import number, percent
from lagrangian_ff.report.page import write_page
from lagrangian_ff.report.sections.lineage import each_joint_section, reasons_section, steps_section
from lagrangian_ff.report.words import spoken


def history_page(path: str | PathLike[str], record: Mapping[str, Any]) -> Path:
    """Write the page. Returns its path.

    Args:
        path: the file to write.
        record: of history.

    Raises:
        OSError: the file cannot be written.
    """
    made = (make(record) for make in SECTIONS)
    return write_page(
        path,
        headline(record),
        [section for section in made if section is not None],
        kicker=f"history of {record.get('model', 'the model')}",
        footer=f"lagrangian_ff {__version__}, made by lagrangian_ff history",
    )


def headline(record: Mapping[str, Any]) -> str:
    """The verdict in one line."""
    steps = record["steps"]
    added = [step for step in steps if step["added"] != "identified"]
    if not added:
        return "Nothing was added since the model was identified"
    names = " and ".join(spoken(str(step["added"])) for step in added)
    first = added[0].get("error_before")
    last = added[-1].get("error_after")
    if first is None or last is None or not first > 0.0:
        return f"Added: {names}"
    whole = f"{_change(first, last)}: {number(first)} → {number(last)} N·m on held-back data"
    joint = str(added[0]["added"]).partition(" on ")[2]
    own = added[0].get("joints", {}).get(joint)
    if len(added) > 1 or own is None or own["before"] is None or not own["before"] > 0.0:
        return f"With {names}, {whole}"
    before, after = own["before"], own["after"]
    return (
        f"With {names}, {_change(before, after, f' of {joint}')}: {number(before)} → "
        f"{number(after)} N·m on held-back data"
    )


def _change(before: float, after: float, of: str = "") -> str:
    left = after / before
    if left <= 1.0:
        return f"{percent(1.0 - left)} of the error{of} is gone"
    return f"the error{of} rose by {percent(left - 1.0)}"


SECTIONS = (steps_section, each_joint_section, reasons_section)
"""The page from top to bottom; what has nothing to say is left out."""
