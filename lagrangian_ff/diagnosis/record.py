"""A diagnosis as JSON holds it: what the command line, the page and the node all show."""

from collections.abc import Mapping, Sequence

import numpy as np

from lagrangian_ff.diagnosis.consequence import (
    Consequence,
    consequences,
)
from lagrangian_ff.diagnosis.diagnose import (
    AMBIGUOUS,
    CONFIRMED,
    SUGGESTED,
    Diagnosis,
    Finding,
    TakenUp,
)
from lagrangian_ff.diagnosis.reason import reason
from lagrangian_ff.diagnosis.search.forward import FLOOR
from lagrangian_ff.diagnosis.search.unnamed import told
from lagrangian_ff.diagnosis.signature import signature
from lagrangian_ff.effects import EFFECTS
from lagrangian_ff.identification.build import seconds
from lagrangian_ff.progress import Progress, silent
from lagrangian_ff.words import listed, which

RANKED = 15
PROMISING = 3.0 * FLOOR
"""Nats of the best effect from which on it is named though chance does as well."""


def diagnosis_record(
    diagnosis: Diagnosis,
    made: Mapping[Finding, Consequence] | None = None,
    progress: Progress = silent,
) -> dict[str, object]:
    """All that was found.

    Args:
        diagnosis: the diagnosis.
        made: what adding the findings does; None works it out.
        progress: told the share done.
    """
    if made is None:
        made = consequences(diagnosis, progress)
    found = diagnosis.search
    threshold = found.chance.threshold
    return {
        "model": diagnosis.model.name,
        "joints": list(diagnosis.model.joints),
        "sources": [diagnosis.motion.source],
        "confirmed_on": diagnosis.unseen.source if diagnosis.separate
        else f"the last {seconds(diagnosis.unseen):.0f} s, held back",
        "verdict": verdict(diagnosis, made),
        "findings": _findings(diagnosis, made),
        "unexplained": [
            {
                "joint": one.joint,
                "coordinate": one.coordinate,
                "share": one.share,
                "evidence_gain": one.gain,
            }
            for one in diagnosis.unexplained
        ],
        "not_observable": [
            {
                "effect": one.effect,
                "joint": one.joint,
                "reason": one.reason,
                "next_motion": one.next_motion,
            }
            for one in diagnosis.not_observable
        ],
        "ranking": [
            {
                "effect": told(score.candidate.source.name, diagnosis.model.joints),
                "joint": diagnosis.model.joints[score.candidate.joint],
                "gain": score.gain,
                "threshold": threshold,
                "named": score.candidate.named,
            }
            for score in found.ranking[:RANKED]
        ],
        "null": {"threshold": threshold, "level": 0.05},
        "noise": dict(zip(diagnosis.model.joints, found.ground.noise.tolist(), strict=True)),
        "steps": _steps(diagnosis, made),
    }  # fmt: skip


def verdict(diagnosis: Diagnosis, made: Mapping[Finding, Consequence]) -> str:
    """One or two sentences for a person."""
    taken_up = diagnosis.taken_up
    sure = [one for one in diagnosis.findings if one.verdict == CONFIRMED]
    unsure = [one for one in diagnosis.findings if one.verdict == AMBIGUOUS]
    maybe = len(diagnosis.findings) - len(sure) - len(unsure)
    parts = []
    if taken_up is not None:
        when = f"{taken_up.change.since:.1f} s"
        felt = which(taken_up.joints, diagnosis.model.joints)
        what = (
            f"From {when} on the arm carries a load that the model does not know"
            if taken_up.change.name == "payload"
            else f"Something touches the arm from {when} to {taken_up.change.until:.1f} s"
        )
        parts.append(f"{what}: {taken_up.verdict}, felt by {felt}.")
    if sure:
        names = listed(_causes(sure))
        parts.append(
            f"Missing and confirmed: {names}{_fall([o for o in sure if o in made], made)}."
        )
    for one in unsure:
        names = " or ".join(_words(name) for name in [one.effect.name, *one.rivals])
        parts.append(
            f"On {one.joint} one of these is missing, this motion cannot tell which: {names}."
        )
    if maybe:
        parts.append(
            f"{maybe} more suggested, not confirmed." if parts
            else f"Nothing is confirmed; {maybe} suggested."
        )  # fmt: skip
    for rest in diagnosis.unexplained:
        parts.append(
            f"On {rest.joint} the torque depends on {rest.coordinate} in a way that no known "
            "effect explains."
        )
    return " ".join(parts) or _nothing(diagnosis)


def _fall(sure: Sequence[Finding], made: Mapping[Finding, Consequence]) -> str:
    """How far the error falls: of one joint, or of all where effects on several are added."""
    if not sure:
        return ""
    first, last = made[sure[0]], made[sure[-1]]
    joint = sure[0].joint
    before, after, whose = first.whole_before, last.whole_after, "the joint's error"
    if any(one.joint != joint for one in sure):
        before, after, whose = first.every_before, last.every_after, "the error over all joints"
    change = "falls" if after < before else "does not fall: it goes"
    return f": {whose} {change} from {before:.3g} to {after:.3g} N·m on motion not used to find it"


def _nothing(diagnosis: Diagnosis) -> str:
    """Whether nothing is left to explain, or the motion is too short to tell it from chance."""
    found = diagnosis.search
    best = next((score for score in found.ranking if score.candidate.named), None)
    if best is None or best.gain <= PROMISING or found.chance.beaten_by(best.gain):
        return (
            "No effect of the catalogue is missing that this motion could show: what is left is "
            "noise."
        )
    candidate = best.candidate
    return (
        f"Nothing stands out from chance. The best guess, {_words(candidate.source.name)} on "
        f"{diagnosis.model.joints[candidate.joint]}, gains {best.gain:.0f} nats; on this motion "
        f"chance gives {found.chance.threshold:.0f} once in twenty times. Record longer: the more "
        "blocks of motion, the less chance can do."
    )


def _findings(diagnosis: Diagnosis, made: Mapping[Finding, Consequence]) -> list[dict[str, object]]:
    """All findings, those that hold first, the largest gain first among these."""
    found = [_finding(diagnosis, one, made.get(one)) for one in diagnosis.findings]
    if diagnosis.taken_up is not None:
        found.append(_event(diagnosis, diagnosis.taken_up))
    order = {CONFIRMED: 0, SUGGESTED: 2}
    found.sort(
        key=lambda one: (order.get(str(one["verdict"]), 1), -float(str(one["evidence_gain"])))
    )
    return found


def _event(diagnosis: Diagnosis, taken_up: TakenUp) -> dict[str, object]:
    """A load or a contact: of the recording and not of the arm, so that nothing is added."""
    effect, change = EFFECTS[taken_up.change.name], taken_up.change
    return {
        "effect": effect.name,
        "joints": list(taken_up.joints),
        "verdict": taken_up.verdict,
        "holds_on_unseen": taken_up.verdict == CONFIRMED,
        "reason": taken_up.reason,
        "why": "",
        "evidence_gain": change.gain,
        "p_value": None,
        "error_before": None,
        "error_after": None,
        "blocks": [],
        "parameters": {
            name: {
                "value": value,
                "low": taken_up.ranges[name][0],
                "high": taken_up.ranges[name][1],
                "unit": "s",
            }
            for name, value in taken_up.shape.items()
        },
        "shape": taken_up.shape,
        "shape_words": effect.shape_words(taken_up.shape, diagnosis.model.joints),
        "formula": effect.formula,
        "meaning": effect.meaning,
        "source": effect.source,
        "ambiguous_with": [],
        "told_apart_by": [],
        "next_motion": effect.next_motion,
    }


def _blocks(made: Consequence | None) -> list[dict[str, float]]:
    if made is None:
        return []
    return [
        {"time": float(t), "before": float(b), "after": float(a)}
        for t, b, a in zip(made.time, made.before, made.after, strict=True)
    ]


def _finding(diagnosis: Diagnosis, found: Finding, made: Consequence | None) -> dict[str, object]:
    effect, step, trial = found.effect, found.step, found.trial
    parameters: dict[str, object] = {
        one.name: {"value": float(v), "low": float(low), "high": float(high), "unit": one.unit}
        for one, v, low, high in zip(
            effect.parameters, found.parameters, found.low, found.high, strict=True
        )
    }
    rivals = list(found.rivals)
    others = [score.candidate.source.name for score in step.rivals]
    motion = effect.next_motion
    told = [effect.look_alikes[name] for name in rivals if name in effect.look_alikes]
    return {
        "effect": effect.name,
        "joints": [found.joint],
        "caused_by": found.cause,
        "verdict": found.verdict if not rivals or found.verdict != AMBIGUOUS
        else f"ambiguous with {', '.join(rivals)}",
        "holds_on_unseen": trial.holds,
        "reason": found.reason,
        "why": reason(found, diagnosis),
        "evidence_gain": step.score.gain,
        "p_value": step.p_value,
        "size": step.score.size,
        "error_before": made.whole_before if made else None,
        "error_after": made.whole_after if made else None,
        "blocks": _blocks(made),
        "parameters": parameters,
        "shape": dict(found.shape),
        "shape_words": effect.shape_words(found.shape, diagnosis.model.joints),
        "shape_units": {shape.name: shape.unit for shape in effect.shapes},
        "formula": effect.formula,
        "meaning": effect.meaning,
        "source": effect.source,
        "ambiguous_with": rivals,
        "ruled_out_by_unseen": [name for name in others if name not in rivals],
        "told_apart_by": told,
        "next_motion": motion,
        "trial": {
            "gained": float(np.sum(trial.gained)),
            "expected": float(np.sum(trial.expected)),
            "ratio": trial.ratio,
            "share": trial.share,
            "p_value": trial.p_value,
        },
        "signature": signature(diagnosis, found),
    }  # fmt: skip


def _steps(diagnosis: Diagnosis, made: Mapping[Finding, Consequence]) -> list[dict[str, object]]:
    added = [one for one in diagnosis.findings if one in made and one.verdict == CONFIRMED]
    if not added:
        return []
    first = made[added[0]].every_before
    steps: list[dict[str, object]] = [{"added": None, "error": first}]
    steps += [
        {"added": f"{one.effect.name} on {one.joint}", "error": made[one].every_after}
        for one in added
    ]
    return steps


def _causes(found: Sequence[Finding]) -> list[str]:
    """Each cause once, however many joints feel it."""
    felt: dict[tuple[str, str], list[str]] = {}
    for one in found:
        felt.setdefault((one.effect.name, one.cause), []).append(one.joint)
    return [
        f"{_words(name)} on {cause}" + (f" (felt on {listed(joints)})" if joints != [cause] else "")
        for (name, cause), joints in felt.items()
    ]


def _words(name: str) -> str:
    return name.replace("_", " ")
