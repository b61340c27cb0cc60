"""The pages of compare, diagnose and history: a title that says the verdict, then the sections."""

import math
import re
from collections.abc import Callable, Mapping, Sequence
from os import PathLike
from pathlib import Path
from typing import Any

from lagrangian_ff import __version__
from lagrangian_ff.numbers import percent, typeset
from lagrangian_ff.report import html
from lagrangian_ff.report.page import Section, write_page
from lagrangian_ff.report.sections.changed import changed_section
from lagrangian_ff.report.sections.errors import errors_section, relative
from lagrangian_ff.report.sections.findings import evidence_section, summary_section
from lagrangian_ff.report.sections.history import (
    each_joint_section,
    fall_section,
    reasons_section,
    steps_section,
)
from lagrangian_ff.report.sections.joints import joints_section
from lagrangian_ff.report.sections.limits import checks_section, next_section, serious_section
from lagrangian_ff.report.sections.ranking import ranking_section
from lagrangian_ff.report.sections.regions import dependence_section, regions_section
from lagrangian_ff.words import spoken

Record = Mapping[str, Any]
Make = Callable[[Record], Section | None]
"""Returns a section of a record; None if it has nothing to say."""


def compare_page(path: str | PathLike[str], record: Record) -> Path:
    """Write where a model fails, and return the path of the page.

    Args:
        path: the file to write.
        record: of a comparison with the series; `model` and `source` name what was compared.

    Raises:
        OSError: the file cannot be written.
    """
    kicker = f"{record.get('model', 'model')} compared with {record['source']}"
    summary = _misses(record)
    return _page(path, "compare", _where_it_fails(record), record, COMPARE, kicker, summary)


def diagnose_page(path: str | PathLike[str], record: Record) -> Path:
    """Write which effect a model lacks and the evidence, and return the path of the page.

    Args:
        path: the file to write.
        record: of a diagnosis; its `compare` is a record of a comparison with the series.

    Raises:
        OSError: the file cannot be written.
    """
    # The heading is the first sentence of the verdict.
    first, *rest = re.split(r"(?<=[.!?])\s+(?=[A-Z])", record["verdict"].strip(), maxsplit=1)
    sources = ", ".join(map(str, record.get("sources") or []))
    kicker = f"{record.get('model', 'model')} diagnosed on {sources}" if sources else ""
    return _page(path, "diagnose", first.rstrip("."), record, DIAGNOSE, kicker, "".join(rest))


def history_page(path: str | PathLike[str], record: Record) -> Path:
    """Write how a model came to be what it is, and return the path of the page.

    Args:
        path: the file to write.
        record: of a history.

    Raises:
        OSError: the file cannot be written.
    """
    kicker = f"history of {record.get('model', 'the model')}"
    return _page(path, "history", _what_was_added(record), record, HISTORY, kicker)


def _page(
    path: str | PathLike[str],
    command: str,
    title: str,
    record: Record,
    makers: Sequence[Make],
    kicker: str,
    summary: str = "",
) -> Path:
    made = (make(record) for make in makers)
    return write_page(
        path,
        title,
        [section for section in made if section is not None],
        kicker=kicker,
        summary=summary,
        footer=f"lagrangian_ff {__version__}, made by lagrangian_ff {command}",
    )


def _where_it_fails(record: Record) -> str:
    if record["regions"]:
        region = record["regions"][0]
        return (
            f"{region['joint']} fails {region['place']}: {percent(region['share_of_error'])} of "
            f"its error in {percent(region['share_of_time'])} of the time"
        )
    if record["too_short"]:
        return "The recording is too short to show where the error lies"
    return "The error is spread evenly over the motion"


def _misses(record: Record) -> str:
    """Return how much of the torque the model misses, and what else to know at first."""
    judged = [
        share for error in record["joints"].values() if math.isfinite(share := relative(error))
    ]
    if not judged:
        return "No joint's torque varied, so that there is nothing to judge."
    text = (
        f"The model misses between {percent(min(judged))} and {percent(max(judged))} of the "
        "torque's spread, depending on the joint."
    )
    if record["outside_range"] > 0.05:
        text += (
            f" {percent(record['outside_range'])} of the motion lies outside what it was "
            "identified on, and there it guesses."
        )
    if record.get("too_sure"):
        text += f" {record['too_sure']}."
    return text


def _what_to_do(record: Record) -> Section:
    model, source = record.get("model", "MODEL"), record.get("sources", [record["source"]])
    texts = [
        "Ask which physical effect is missing, with the evidence for each: lagrangian_ff diagnose "
        f"{model} {' '.join(map(str, source))}"
    ]
    if record["outside_range"] > 0.05:
        texts.append(
            "Identify again from a recording that goes where this one goes: a model knows the "
            "motion it has seen."
        )
    return Section("What to do next", "", html.steps(texts))


def _what_was_added(record: Record) -> str:
    added = [step for step in record["steps"] if step["added"] != "identified"]
    if not added:
        return "Nothing was added since the model was identified"
    names = " and ".join(spoken(str(step["added"])) for step in added)
    before, after, of = added[0].get("error_before"), added[-1].get("error_after"), ""
    if before is None or after is None or not before > 0.0:
        return f"Added: {names}"
    if len(added) == 1:  # which one joint feels most
        joint = str(added[0]["added"]).partition(" on ")[2]
        own = added[0].get("joints", {}).get(joint)
        if own is not None and own["before"] is not None and own["before"] > 0.0:
            before, after, of = own["before"], own["after"], f" of {joint}"
    left = after / before
    change = (
        f"{percent(1.0 - left)} of the error{of} is gone"
        if left <= 1.0
        else f"the error{of} rose by {percent(left - 1.0)}"
    )
    return f"With {names}, {change}: {typeset(before)} → {typeset(after)} N·m on held-back data"


def _of_comparison(make: Make) -> Make:
    """Return a section of a comparison as one of the diagnosis that holds it."""
    return lambda record: make(record["compare"]) if record.get("compare") else None


def _joints_of_diagnosis(record: Record) -> Section | None:
    """Return the panels of all joints, that of the first finding on top."""
    if not record.get("compare"):
        return None
    first = next((one["joints"][0] for one in record["findings"] if one["joints"]), None)
    return joints_section(record["compare"], first)


COMPARE: list[Make] = [
    errors_section, regions_section, dependence_section, joints_section, _what_to_do,
]  # fmt: skip
DIAGNOSE: list[Make] = [
    serious_section,
    summary_section,
    changed_section,
    _of_comparison(regions_section),
    evidence_section,
    ranking_section,
    fall_section,
    next_section,
    _of_comparison(errors_section),
    _of_comparison(dependence_section),
    _joints_of_diagnosis,
    checks_section,
]
HISTORY: list[Make] = [steps_section, each_joint_section, reasons_section]
"""The sections of each page from top to bottom."""
