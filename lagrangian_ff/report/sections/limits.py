"""What is wrong with the measurement, what disturbed it or does not show, and what to do next."""

from typing import TYPE_CHECKING

from lagrangian_ff.numbers import chance, percent, typeset
from lagrangian_ff.report import html
from lagrangian_ff.report.page import Section
from lagrangian_ff.words import sentence, spoken, which

if TYPE_CHECKING:
    from lagrangian_ff.diagnosis import DiagnosisRun
    from lagrangian_ff.diagnosis.preflight import Check


def serious_section(run: "DiagnosisRun") -> Section | None:
    """Return the faults of the measurement that must be mended before an effect is believed."""
    if not run.serious:
        return None
    return Section(
        "First: the measurement",
        "These faults look like missing physics. Fix them before believing any effect.",
        html.bullets(map(_fault, run.serious)),
    )


def _fault(check: "Check") -> str:
    """Return what was found and what to do; names the joint first if the text does not."""
    advice = sentence(check.advice) if check.advice else ""
    text, joint = f"{sentence(check.finding)} {advice}".strip(), check.joint
    return text if not joint or joint in text else f"{joint}: {text}"


def touched_section(run: "DiagnosisRun") -> Section | None:
    """Return what touched the arm while it was recorded; None if nothing did."""
    rows = [
        [
            f"{one.begin:.2f} to {one.end:.2f} s",
            joint,
            typeset(size.value),
            f"{typeset(size.low)} to {typeset(size.high)}",
            chance(one.p_value),
            "sure" if one.sure else "suggested",
            one.source,
        ]
        for one in run.diagnosis.contacts
        for joint, size in one.sizes.items()
    ]
    if not rows:
        return None
    header = ["when", "joint", "torque [N·m]", "90 % interval", "p", "verdict", "recording"]
    lead = (
        "For a moment the actuators gave this torque beyond what the motion took, and neither the "
        "model's own errors nor chance explain it. Leave these moments out of what is learned from."
    )
    return Section("What touched the arm", lead, html.table(header, rows))


def usual_section(run: "DiagnosisRun") -> Section | None:
    """Return what is usual in the gears of the joints that something was found on."""
    if not run.usual:
        return None
    lead = "Known of such gears in general. It is not part of the evidence, and decides nothing."
    bullets = html.bullets(f"{spoken(name)}: {words}" for name, words in run.usual.items())
    return Section("What is usual in such gears", lead, bullets)


def checks_section(run: "DiagnosisRun") -> Section | None:
    """Return all that was checked of the measurement."""
    if not run.checks:
        return None
    rows = [
        [spoken(one.check), one.joint or "all", one.finding, "fix first" if one.serious else "fine"]
        for one in run.checks
    ]
    table = html.table(["check", "joint", "found", ""], rows, words=4)
    return Section("The measurement", "What was checked before any effect was looked for.", table)


def next_section(run: "DiagnosisRun") -> Section | None:
    """Return which motion would show more, and what was left unexplained."""
    diagnosis, every = run.diagnosis, run.diagnosis.model.joints
    parts = []
    motions: dict[str, list[str]] = {}
    for found in diagnosis.found:
        if found.effect.next_motion and not found.confirmed:
            who = f"{spoken(found.effect.name)} on {found.place(every)}"
            motions.setdefault(found.effect.next_motion, []).append(who)
    hidden: dict[str, dict[str, list[str]]] = {}
    for one in diagnosis.not_observable:
        hidden.setdefault(one.next_motion, {}).setdefault(one.effect, []).append(one.joint)
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
    if diagnosis.unexplained:
        texts = [
            f"{one.joint}: something {percent(one.share)} the size of its torque follows "
            f"{spoken(one.coordinate)}, and no effect of the catalogue accounts for it."
            for one in diagnosis.unexplained
        ]
        parts.append(f'<h3 class="plain">Left unexplained</h3>{html.bullets(texts)}')
    if diagnosis.remainders:
        texts = [
            f"{one.joint}: {one.size:.2g} N·m, {percent(one.share)} of its torque, changes more "
            "slowly than noise does."
            for one in diagnosis.remainders
        ]
        parts.append(f'<h3 class="plain">More than noise is left</h3>{html.bullets(texts)}')
    if not parts:
        return None
    return Section("What to record next", "", "".join(parts))
