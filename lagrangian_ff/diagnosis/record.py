"""The JSON of a diagnosis, which the command line, the page and the node show."""

from collections.abc import Sequence
from dataclasses import asdict

import numpy as np

from lagrangian_ff.diagnosis import thresholds
from lagrangian_ff.diagnosis.adding import reason
from lagrangian_ff.diagnosis.results import (
    Consequence,
    Consequences,
    Diagnosis,
    Finding,
    TakenUp,
    Verdict,
)
from lagrangian_ff.effects import look_alikes
from lagrangian_ff.identification.build import seconds
from lagrangian_ff.words import listed, which

RANKED = 15


def diagnosis_record(diagnosis: Diagnosis, made: Consequences) -> dict[str, object]:
    """Return the JSON of a diagnosis.

    Args:
        diagnosis: the diagnosis.
        made: the consequences of adding the findings, from `consequences`.
    """
    return {
        "model": diagnosis.model.name,
        "joints": list(diagnosis.model.joints),
        "sources": [diagnosis.motion.source],
        "confirmed_on": diagnosis.held_out.source if diagnosis.separate
        else f"the last {seconds(diagnosis.held_out):.0f} s, held back",
        "verdict": verdict(diagnosis, made),
        "findings": _findings(diagnosis, made),
        "unexplained": [
            {
                "joint": one.joint,
                "coordinate": one.coordinate,
                "share": one.share,
                "evidence_gain": one.log_bayes_factor,
            }
            for one in diagnosis.unexplained
        ],
        "not_observable": [asdict(one) for one in diagnosis.not_observable],
        "ranking": [
            {
                "effect": one.name,
                "joint": one.joint,
                "gain": one.log_bayes_factor,
                "threshold": diagnosis.threshold,
                "named": one.named,
            }
            for one in diagnosis.ranking[:RANKED]
        ],
        "null": {"threshold": diagnosis.threshold, "level": thresholds.USED.level},
        "noise": dict(zip(diagnosis.model.joints, diagnosis.noise.tolist(), strict=True)),
        "steps": _steps(diagnosis, made),
    }  # fmt: skip


def verdict(diagnosis: Diagnosis, made: Consequences) -> str:
    """Return the verdict in one or two sentences for a person."""
    taken_up = diagnosis.taken_up
    sure = [one for one in diagnosis.findings if one.verdict is Verdict.CONFIRMED]
    unsure = [one for one in diagnosis.findings if one.verdict is Verdict.AMBIGUOUS]
    maybe = len(diagnosis.findings) - len(sure) - len(unsure)
    parts = []
    if taken_up is not None:
        when = f"{taken_up.change.since:.1f} s"
        felt = which(taken_up.joints, diagnosis.model.joints)
        what = (
            f"From {when} on the arm carries a load that the model does not know"
            if taken_up.change.lasts
            else f"Something touches the arm from {when} to {taken_up.change.until:.1f} s"
        )
        parts.append(f"{what}: {taken_up.verdict.value}, felt by {felt}.")
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


def _fall(sure: Sequence[Finding], made: Consequences) -> str:
    """Return the fall of the error in words: of one joint, or of all if several are concerned."""
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
    """Return the sentence for no findings: nothing is left, or the motion is too short."""
    best = next((one for one in diagnosis.ranking if one.named), None)
    if best is None or best.log_bayes_factor <= thresholds.USED.promising or best.stands_out:
        return (
            "No effect of the catalogue is missing that this motion could show: what is left is "
            "noise."
        )
    return (
        f"Nothing stands out from chance. The best guess, {_words(best.name)} on {best.joint}, "
        f"gains {best.log_bayes_factor:.0f} nats; on this motion chance gives "
        f"{diagnosis.threshold:.0f} once in twenty times. Record longer: the more blocks of "
        "motion, the less chance can do."
    )


def _findings(diagnosis: Diagnosis, made: Consequences) -> list[dict[str, object]]:
    """Return all findings by verdict, the largest log Bayes factor first."""
    found = [_finding(diagnosis, one, made.get(one)) for one in diagnosis.findings]
    if diagnosis.taken_up is not None:
        found.append(_event(diagnosis, diagnosis.taken_up))
    order = {Verdict.CONFIRMED.value: 0, Verdict.SUGGESTED.value: 2}
    found.sort(
        key=lambda one: (order.get(str(one["verdict"]), 1), -float(str(one["evidence_gain"])))
    )
    return found


def _event(diagnosis: Diagnosis, taken_up: TakenUp) -> dict[str, object]:
    """Return a load or a contact, which belongs to the recording and is not added."""
    effect, change = taken_up.change.effect, taken_up.change
    return {
        "effect": effect.name,
        "joints": list(taken_up.joints),
        "verdict": taken_up.verdict.value,
        "holds_on_unseen": taken_up.verdict is Verdict.CONFIRMED,
        "reason": taken_up.doubt.words if taken_up.doubt else "",
        "why": "",
        "evidence_gain": change.log_bayes_factor,
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
    effect, hold_out, doubt = found.effect, found.hold_out, found.doubt
    parameters: dict[str, object] = {
        one.name: {"value": float(v), "low": float(low), "high": float(high), "unit": one.unit}
        for one, v, low, high in zip(
            effect.parameters, found.parameters, found.low, found.high, strict=True
        )
    }
    rivals, known = list(found.rivals), look_alikes(effect)
    return {
        "effect": effect.name,
        "joints": [found.joint],
        "caused_by": found.cause,
        "verdict": f"ambiguous with {', '.join(rivals)}"
        if found.verdict is Verdict.AMBIGUOUS else found.verdict.value,
        "holds_on_unseen": hold_out.holds,
        "reason": doubt.words if doubt else "",
        "why": reason(found, diagnosis),
        "evidence_gain": found.log_bayes_factor,
        "p_value": found.p_value,
        "size": found.size,
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
        "ruled_out_by_unseen": list(found.ruled_out),
        "told_apart_by": [known[name] for name in rivals if name in known],
        "next_motion": effect.next_motion,
        "trial": {
            "gained": float(np.sum(hold_out.gained)),
            "expected": float(np.sum(hold_out.expected)),
            "ratio": hold_out.ratio,
            "share": hold_out.share,
            "p_value": hold_out.p_value,
        },
        "signature": {
            name: value.tolist() if isinstance(value, np.ndarray) else value
            for name, value in vars(found.partial_residual).items()
        },
    }  # fmt: skip


def _steps(diagnosis: Diagnosis, made: Consequences) -> list[dict[str, object]]:
    added = [one for one in diagnosis.findings if one in made and one.verdict is Verdict.CONFIRMED]
    if not added:
        return []
    after = [
        {"added": f"{one.effect.name} on {one.joint}", "error": made[one].every_after}
        for one in added
    ]
    return [{"added": None, "error": made[added[0]].every_before}, *after]


def _causes(found: Sequence[Finding]) -> list[str]:
    """Return each cause in words, once, with the joints that feel it."""
    felt: dict[tuple[str, str], list[str]] = {}
    for one in found:
        felt.setdefault((one.effect.name, one.cause), []).append(one.joint)
    return [
        f"{_words(name)} on {cause}" + (f" (felt on {listed(joints)})" if joints != [cause] else "")
        for (name, cause), joints in felt.items()
    ]


def _words(name: str) -> str:
    return name.replace("_", " ")
