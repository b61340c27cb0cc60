"""The page of compare: where a model fails."""

import math
from collections.abc import Mapping
from os import PathLike
from pathlib import Path
from typing import Any

from lagrangian_ff import __version__
from lagrangian_ff.report import html
from lagrangian_ff.report.numbers import percent
from lagrangian_ff.report.page import write_page
from lagrangian_ff.report.section import Section
from lagrangian_ff.report.sections.errors import errors_section, relative
from lagrangian_ff.report.sections.joints import joints_section
from lagrangian_ff.report.sections.regions import dependence_section, regions_section


def compare_page(path: str | PathLike[str], record: Mapping[str, Any]) -> Path:
    """Write the page. Returns its path.

    Args:
        path: the file to write.
        record: of compare with the series; `model` and `source` name what was compared.

    Raises:
        OSError: the file cannot be written.
    """
    return write_page(
        path,
        headline(record),
        [make(record) for make in SECTIONS],
        kicker=f"{record.get('model', 'model')} held against {record['source']}",
        summary=summary(record),
        footer=f"lagrangian_ff {__version__}, made by lagrangian_ff compare",
    )


def headline(record: Mapping[str, Any]) -> str:
    """The verdict in one line."""
    if record["regions"]:
        region = record["regions"][0]
        return (
            f"{region['joint']} fails {region['place']}: {percent(region['share_of_error'])} of "
            f"its error in {percent(region['share_of_time'])} of the time"
        )
    if record["too_short"]:
        return "The recording is too short to tell where the error lies"
    return "The error is spread evenly over the motion"


def summary(record: Mapping[str, Any]) -> str:
    """What else to know at first."""
    judged = {
        name: share
        for name, error in record["joints"].items()
        if math.isfinite(share := relative(error))
    }
    if not judged:
        return "No joint's torque varied, so that there is nothing to judge."
    low, high = min(judged.values()), max(judged.values())
    text = (
        f"The model misses between {percent(low)} and {percent(high)} of the torque's spread, "
        "depending on the joint."
    )
    if record["outside_range"] > 0.05:
        text += (
            f" {percent(record['outside_range'])} of the motion lies outside what it was "
            "identified on, and there it guesses."
        )
    if record.get("too_sure"):
        text += f" {record['too_sure']}."
    return text


def _next(record: Mapping[str, Any]) -> Section:
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


SECTIONS = (errors_section, regions_section, dependence_section, joints_section, _next)
"""The page from top to bottom."""
