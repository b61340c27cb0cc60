"""What the diagnosis cannot tell, what is wrong with the measurement, and what to record next."""

from collections.abc import Mapping
from typing import Any

from lagrangian_ff.report import html
from lagrangian_ff.report.numbers import percent
from lagrangian_ff.report.section import Section
from lagrangian_ff.report.words import sentence, spoken
from lagrangian_ff.words import where, which


def serious_section(record: Mapping[str, Any]) -> Section | None:
    """Faults of the measurement that must be mended before any effect is believed.

    Args:
        record: of diagnose.
    """
    serious = [one for one in record.get("preflight") or [] if one.get("serious")]
    if not serious:
        return None
    texts = [_named(one) for one in serious]
    return Section(
        "First: the measurement",
        "These faults look like missing physics. Fix them before believing any effect.",
        html.bullets(texts),
    )


def _named(check: Mapping[str, Any]) -> str:
    """What was found and what to do, with the joint where the sentence does not name it."""
    told, joint = _told(check), check.get("joint")
    return told if not joint or joint in told else f"{joint}: {told}"


def checks_section(record: Mapping[str, Any]) -> Section | None:
    """All that was checked of the measurement.

    Args:
        record: of diagnose.
    """
    checks = record.get("preflight") or []
    if not checks:
        return None
    rows = [
        [
            spoken(str(one["check"])),
            one.get("joint") or "all",
            one["finding"],
            "fix first" if one.get("serious") else "fine",
        ]
        for one in checks
    ]
    table = html.table(["check", "joint", "found", ""], rows, words=4)
    return Section("The measurement", "What was checked before any effect was looked for.", table)


def next_section(record: Mapping[str, Any]) -> Section | None:
    """Which motion would tell more, and what was left unexplained.

    Args:
        record: of diagnose.
    """
    parts = []
    motions: dict[str, list[str]] = {}
    for one in record["findings"]:
        if one.get("next_motion") and one["verdict"] != "confirmed":
            who = f"{spoken(one['effect'])} on {where(one, record.get('joints', ()))}"
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
            [spoken(effect), which(joints, record.get("joints", ())), motion]
            for motion, effects in hidden.items()
            for effect, joints in effects.items()
        ]
        table = html.table(["effect", "joints", "motion that would show it"], rows, words=3)
        parts.append(
            '<h3 class="plain">What this motion could not show</h3>'
            + html.paragraph(
                "The model absorbs so much of these effects on this motion that nothing is said "
                "about them: neither that they are there, nor that they are not."
            )
            + table
        )
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


def _told(one: Mapping[str, Any]) -> str:
    advice = sentence(one["advice"]) if one.get("advice") else ""
    return f"{sentence(one['finding'])} {advice}".strip()
