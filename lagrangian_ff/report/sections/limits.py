"""What is wrong with the measurement, what it could not show, and what to record next."""

from collections.abc import Mapping
from typing import Any

from lagrangian_ff.numbers import percent
from lagrangian_ff.report import html
from lagrangian_ff.report.page import Section
from lagrangian_ff.words import sentence, spoken, standing, where, which


def serious_section(record: Mapping[str, Any]) -> Section | None:
    """Return the faults of the measurement that must be mended before an effect is believed."""
    serious = [one for one in record.get("preflight") or [] if one.get("serious")]
    if not serious:
        return None
    return Section(
        "First: the measurement",
        "These faults look like missing physics. Fix them before believing any effect.",
        html.bullets(map(_fault, serious)),
    )


def _fault(check: Mapping[str, Any]) -> str:
    """Return what was found and what to do; names the joint first if the text does not."""
    advice = sentence(check["advice"]) if check.get("advice") else ""
    text, joint = f"{sentence(check['finding'])} {advice}".strip(), check.get("joint")
    return text if not joint or joint in text else f"{joint}: {text}"


def checks_section(record: Mapping[str, Any]) -> Section | None:
    """Return all that was checked of the measurement."""
    checks = record.get("preflight") or []
    if not checks:
        return None
    rows = [
        [spoken(str(one["check"])), one.get("joint") or "all", one["finding"], mark]
        for one in checks
        for mark in ["fix first" if one.get("serious") else "fine"]
    ]
    table = html.table(["check", "joint", "found", ""], rows, words=4)
    return Section("The measurement", "What was checked before any effect was looked for.", table)


def next_section(record: Mapping[str, Any]) -> Section | None:
    """Return which motion would show more, and what was left unexplained."""
    every = record.get("joints", ())
    parts = []
    motions: dict[str, list[str]] = {}
    for one in record["findings"]:
        if one.get("next_motion") and standing(one) != "confirmed":
            who = f"{spoken(one['effect'])} on {where(one, every)}"
            motions.setdefault(one["next_motion"], []).append(who)
    hidden: dict[str, dict[str, list[str]]] = {}
    for one in record.get("not_observable") or []:
        hidden.setdefault(one["next_motion"], {}).setdefault(one["effect"], []).append(one["joint"])
    if motions:
        texts = [
            f"{sentence(motion)} It settles {', '.join(who)}." for motion, who in motions.items()
        ]
        parts.append(f'<h3 class="plain">To settle what was found</h3>{html.bullets(texts)}')
    if hidden:
        rows = [
            [spoken(effect), which(joints, every), motion]
            for motion, effects in hidden.items()
            for effect, joints in effects.items()
        ]
        table = html.table(["effect", "joints", "motion that would show it"], rows, words=3)
        why = html.paragraph(
            "The model absorbs so much of these effects on this motion that nothing is said about "
            "them: neither that they are there, nor that they are not."
        )
        parts.append(f'<h3 class="plain">What this motion could not show</h3>{why}{table}')
    left = record.get("unexplained") or []
    if left:
        texts = [
            f"{one['joint']}: something {percent(one['share'])} the size of its torque follows "
            f"{spoken(one['coordinate'])}, and no effect of the catalogue accounts for it."
            for one in left
        ]
        parts.append(f'<h3 class="plain">Left unexplained</h3>{html.bullets(texts)}')
    if not parts:
        return None
    return Section("What to record next", "", "".join(parts))
