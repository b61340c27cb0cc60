"""The page of diagnose: which physical effect is missing, and how one knows."""

import re
from collections.abc import Mapping
from os import PathLike
from pathlib import Path
from typing import Any

from lagrangian_ff import __version__
from lagrangian_ff.report.page import write_page
from lagrangian_ff.report.section import Section
from lagrangian_ff.report.sections.errors import errors_section
from lagrangian_ff.report.sections.fall import fall_section
from lagrangian_ff.report.sections.findings import evidence_section, summary_section
from lagrangian_ff.report.sections.joints import joints_section
from lagrangian_ff.report.sections.limits import checks_section, next_section, serious_section
from lagrangian_ff.report.sections.ranking import ranking_section
from lagrangian_ff.report.sections.regions import dependence_section, regions_section


def diagnose_page(path: str | PathLike[str], record: Mapping[str, Any]) -> Path:
    """Write the page. Returns its path.

    Args:
        path: the file to write.
        record: of diagnose; its `compare` is a record of compare with the series.

    Raises:
        OSError: the file cannot be written.
    """
    title, summary = split(record["verdict"])
    sources = ", ".join(map(str, record.get("sources") or []))
    made = (make(record) for make in SECTIONS)
    return write_page(
        path,
        title,
        [section for section in made if section is not None],
        kicker=f"{record.get('model', 'model')} diagnosed on {sources}" if sources else "",
        summary=summary,
        footer=f"lagrangian_ff {__version__}, made by lagrangian_ff diagnose",
    )


def split(verdict: str) -> tuple[str, str]:
    """The first sentence, for the heading, and the rest."""
    first, *rest = re.split(r"(?<=[.!?])\s+(?=[A-Z])", verdict.strip(), maxsplit=1)
    return first.rstrip("."), "".join(rest)


def _regions(record: Mapping[str, Any]) -> Section | None:
    return regions_section(record["compare"]) if record.get("compare") else None


def _errors(record: Mapping[str, Any]) -> Section | None:
    return errors_section(record["compare"]) if record.get("compare") else None


def _dependence(record: Mapping[str, Any]) -> Section | None:
    return dependence_section(record["compare"]) if record.get("compare") else None


def _joints(record: Mapping[str, Any]) -> Section | None:
    if not record.get("compare"):
        return None
    first = next((one["joints"][0] for one in record["findings"] if one["joints"]), None)
    return joints_section(record["compare"], first)


SECTIONS = (
    serious_section,
    summary_section,
    _regions,
    evidence_section,
    ranking_section,
    fall_section,
    next_section,
    _errors,
    _dependence,
    _joints,
    checks_section,
)
"""The page from top to bottom; what has nothing to say is left out."""
