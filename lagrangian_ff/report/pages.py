"""The pages of compare, diagnose, history and info: a title with the verdict, then the sections.

Each function writes its page to a path, and returns it; OSError says why that is not possible.
"""

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, TypeVar

from lagrangian_ff import __version__
from lagrangian_ff.identification.history import ErrorChange, History, Step
from lagrangian_ff.numbers import percent, typeset
from lagrangian_ff.report import html
from lagrangian_ff.report.page import Section, write_page
from lagrangian_ff.report.sections.bandwidth import bandwidth_section
from lagrangian_ff.report.sections.changed import changed_section
from lagrangian_ff.report.sections.errors import errors_section, relative
from lagrangian_ff.report.sections.findings import evidence_section, fall_section, summary_section
from lagrangian_ff.report.sections.history import each_joint_section, reasons_section, steps_section
from lagrangian_ff.report.sections.joints import joints_section
from lagrangian_ff.report.sections.limits import (
    checks_section,
    next_section,
    serious_section,
    touched_section,
    usual_section,
)
from lagrangian_ff.report.sections.ranking import ranking_section
from lagrangian_ff.report.sections.regions import dependence_section, regions_section
from lagrangian_ff.report.sections.story import (
    ended_section,
    staircase_section,
    turns_section,
    unlisted_section,
)
from lagrangian_ff.words import counted, sentence, spoken

if TYPE_CHECKING:
    from lagrangian_ff.diagnosis import Comparison, DiagnosisRun
    from lagrangian_ff.diagnosis.where import Compared, Localisation
    from lagrangian_ff.investigation import Investigation
    from lagrangian_ff.recording import Bandwidth, Inspection

Result = TypeVar("Result")
Make = Callable[[Result], Section | None]
"""Returns a section of a result; None if it has nothing to say."""


@dataclass(frozen=True)
class Read:
    """A recording as it is read: what it holds, its bandwidth, and what was done to it."""

    inspection: "Inspection"
    bandwidth: "Bandwidth"
    notes: tuple[str, ...]


def compare_page(path: str | PathLike[str], found: "Compared") -> Path:
    """Write where a model fails, and return the path of the page."""
    where = found.where
    kicker = f"{found.model} compared with {where.comparison.motion.source}"
    summary = _misses(where.comparison)
    return _page(path, "compare", _where_it_fails(where), found, COMPARE, kicker, summary)


def diagnose_page(path: str | PathLike[str], run: "DiagnosisRun") -> Path:
    """Write which effect a model lacks and the evidence, and return the path of the page."""
    from lagrangian_ff.diagnosis import verdict

    # The heading is the first sentence of the verdict.
    first, *rest = re.split(
        r"(?<=[.!?])\s+(?=[A-Z])", verdict(run.diagnosis, run.changed), maxsplit=1
    )
    kicker = f"{run.model_file} diagnosed on {', '.join(run.sources)}"
    return _page(path, "diagnose", first.rstrip("."), run, DIAGNOSE, kicker, "".join(rest))


def history_page(path: str | PathLike[str], history: History) -> Path:
    """Write how a model came to be what it is, and return the path of the page."""
    title, kicker = _what_was_added(history.steps), f"history of {history.file}"
    return _page(path, "history", title, history, HISTORY, kicker)


def investigation_page(path: str | PathLike[str], story: "Investigation") -> Path:
    """Write the story of an investigation, and return the path of the page."""
    from lagrangian_ff.investigation import Ended

    found = [spoken(one.name) for one in story.confirmed]
    if not story.turns:
        still = story.ended is Ended.REFUSED
        title = "The arm did not move" if still else "It ended before anything was known"
    elif not found:
        last, last_errors = story.turns[-1].diagnosis, story.turns[-1].errors
        title = "Nothing is missing that these motions can show"
        if story.curves:
            joint = story.curves[0].joint
            fall = f"{typeset(last_errors[joint])} → {typeset(story.errors[joint])} N·m"
            title = f"A torque of {joint} that nobody listed, held as a curve: {fall} unseen"
        elif last.found or last.unexplained:
            title = "Something may be missing; these motions confirm nothing"
    else:
        title = f"Found {' and '.join(found)}"
        before, after = story.confirmed[0].errors
        if before is not None and after is not None:
            fall = f"{typeset(before)} → {typeset(after)} N·m"
            title += f": the unseen error of {story.confirmed[0].joint} falls, {fall}"
    asked = counted(len(story.turns), "question")
    kicker = f"{asked} to {len(story.joints)} joints, {story.seconds:.0f} s"
    return _page(path, "investigate", title, story, INVESTIGATION, kicker)


def recording_page(path: str | PathLike[str], found: "Read") -> Path:
    """Write what a recording holds and how it is made ready, and return the path of the page."""
    lines = found.inspection.lines()
    title = f"{lines[1].split(';')[0].strip()} of {len(found.inspection.joints)} joints"
    return _page(path, "info", title, found, RECORDING, f"info {found.inspection.source}")


def _page(
    path: str | PathLike[str],
    command: str,
    title: str,
    result: Result,
    makers: Sequence[Make[Result]],
    kicker: str,
    summary: str = "",
) -> Path:
    made = (make(result) for make in makers)
    return write_page(
        path,
        title,
        [section for section in made if section is not None],
        kicker=kicker,
        summary=summary,
        footer=f"lagrangian_ff {__version__}, made by lagrangian_ff {command}",
    )


def _where_it_fails(where: "Localisation") -> str:
    if where.regions:
        region = where.regions[0]
        return (
            f"{region.joint} fails {region.place}: {percent(region.share_of_error)} of "
            f"its error in {percent(region.share_of_time)} of the time"
        )
    if where.series.too_short:
        return "The recording is too short to show where the error lies"
    return "The error is spread evenly over the motion"


def _misses(comparison: "Comparison") -> str:
    """Return how much of the torque the model misses, and what else to know at first."""
    judged = relative(comparison.score).values()
    if not judged:
        return "No joint's torque varied, so that there is nothing to judge."
    text = (
        f"The model misses between {percent(min(judged))} and {percent(max(judged))} of the "
        "torque's spread, depending on the joint."
    )
    if comparison.outside > 0.05:
        text += (
            f" {percent(comparison.outside)} of the motion lies outside what it was "
            "identified on, and there it guesses."
        )
    return f"{text} {comparison.warning}." if comparison.warning else text


def _what_to_do(found: "Compared") -> Section:
    texts = [
        "Ask which physical effect is missing, with the evidence for each: lagrangian_ff diagnose "
        f"{found.model} {' '.join(found.sources)}"
    ]
    if found.where.comparison.outside > 0.05:
        texts.append(
            "Identify again from a recording that goes where this one goes: a model knows the "
            "motion it has seen."
        )
    return Section("What to do next", "", html.steps(texts))


def _what_was_added(steps: Sequence[Step]) -> str:
    added = [step for step in steps if step.added != "identified"]
    if not added:
        return "Nothing was added since the model was identified"
    names = " and ".join(spoken(step.added) for step in added)
    error, of = ErrorChange(added[0].error_before, added[-1].error_after), ""
    if error.left is None:
        return f"Added: {names}"
    if len(added) == 1:  # which one joint feels most
        joint = added[0].added.partition(" on ")[2]
        own = added[0].joints.get(joint)
        if own is not None and own.left is not None:
            error, of = own, f" of {joint}"
    left = error.left or 0.0
    change = (
        f"{percent(1.0 - left)} of the error{of} is gone"
        if left <= 1.0
        else f"the error{of} rose by {percent(left - 1.0)}"
    )
    fall = f"{typeset(error.before)} → {typeset(error.after)} N·m"
    return f"With {names}, {change}: {fall} on held-back data"


def _bandwidth(found: "Read") -> Section:
    return bandwidth_section(found.bandwidth)


def _found(found: "Read") -> Section:
    lead = "What was recorded, and what was done to make a motion of it."
    lines = [line.strip() for line in found.inspection.lines()[1:]]
    notes = [note for note in found.notes if note not in found.inspection.notes]
    return Section("The recording", lead, html.bullets(sentence(one) for one in [*lines, *notes]))


def _located(make: "Make[Localisation]") -> "Make[Compared]":
    """Return a section of the error's localisation as one of the comparison that holds it."""
    return lambda found: make(found.where)


def _of_comparison(make: "Make[Localisation]") -> "Make[DiagnosisRun]":
    """Return a section of the error's localisation as one of the diagnosis that holds it."""
    return lambda run: make(run.where) if run.where else None


def _evidence(run: "DiagnosisRun") -> Section | None:
    return evidence_section(run.diagnosis)


def _evidence_in_the_end(story: "Investigation") -> Section | None:
    return evidence_section(story.turns[-1].diagnosis) if story.turns else None


def _joints_of_diagnosis(run: "DiagnosisRun") -> Section | None:
    """Return the panels of all joints, that of the first finding on top."""
    if run.where is None:
        return None
    first = next((one.joints[0] for one in run.diagnosis.found if one.joints), None)
    return joints_section(run.where, first)


COMPARE: "list[Make[Compared]]" = [
    *map(_located, (errors_section, regions_section, dependence_section, joints_section)),
    _what_to_do,
]
DIAGNOSE: "list[Make[DiagnosisRun]]" = [
    serious_section,
    summary_section,
    changed_section,
    touched_section,
    _of_comparison(regions_section),
    _evidence,
    ranking_section,
    fall_section,
    usual_section,
    next_section,
    _of_comparison(errors_section),
    _of_comparison(dependence_section),
    _joints_of_diagnosis,
    checks_section,
]
INVESTIGATION: "list[Make[Investigation]]" = [
    turns_section,
    staircase_section,
    _evidence_in_the_end,
    unlisted_section,
    ended_section,
]
HISTORY: list[Make[History]] = [steps_section, each_joint_section, reasons_section]
RECORDING: "list[Make[Read]]" = [_bandwidth, _found]
"""The sections of each page from top to bottom."""
