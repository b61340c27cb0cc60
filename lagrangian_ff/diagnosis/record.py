"""The JSON of a diagnosis, as the command line and the node write it; and its findings read back.

A function here only renames and lists what the types of `results` and `run` hold.
"""

import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from lagrangian_ff.diagnosis import thresholds
from lagrangian_ff.diagnosis.consequence import Consequence
from lagrangian_ff.diagnosis.misfit import Misfit
from lagrangian_ff.diagnosis.preflight.base import Check
from lagrangian_ff.diagnosis.results import Diagnosis, Finding, Found, Unexplained
from lagrangian_ff.diagnosis.run import Changed, DiagnosisRun
from lagrangian_ff.diagnosis.sentences import curve_command, history_of_curve, reason, verdict
from lagrangian_ff.identification.records import Estimate
from lagrangian_ff.record_json import by_name

RANKED = 15

Record = dict[str, Any]


def run_record(run: DiagnosisRun) -> Record:
    """Return all that a run of `diagnose` found."""
    record = {
        **diagnosis_record(run.diagnosis),
        "verdict": verdict(run.diagnosis, run.changed),
        "model": run.model_file,
        "model_name": run.diagnosis.model.name,
        "unexplained": [_unexplained(one, run.model_file) for one in run.diagnosis.unexplained],
        "sources": list(run.sources),
        "confirm": list(run.confirm),
    }
    if run.output:
        record["steps"] = _steps(run.tried, joints=True)
        record["applied"] = {
            "output": run.output if run.rounds[0].after is not None else None,
            "added": [name for one in run.rounds for name in one.added],
            "rounds": [
                {"verdict": verdict(one.diagnosis), "added": list(one.added)} for one in run.rounds
            ],
        }
    record["preflight"] = [check_record(one) for one in run.checks]
    if run.gears:
        record["usual"] = run.usual
    if run.changed is not None:
        record["changed"] = [changed_record(one) for one in run.changed]
    if run.where is not None:
        record["compare"] = run.where.record()
    return record


def diagnosis_record(diagnosis: Diagnosis) -> Record:
    """Return one diagnosis, with the consequences of adding its findings if they were tried."""
    return {
        "model": diagnosis.model.name,
        "joints": list(diagnosis.model.joints),
        "sources": [diagnosis.motion.source],
        "confirmed_on": diagnosis.confirmed_on,
        "verdict": verdict(diagnosis),
        "seconds_wanting": diagnosis.wanting,
        "findings": [_finding(diagnosis, one) for one in diagnosis.found],
        "unexplained": [_unexplained(one, "MODEL.npz") for one in diagnosis.unexplained],
        "more_than_noise": [asdict(one) for one in diagnosis.remainders],
        "missed_on_unseen": dict(diagnosis.missed),
        "lag": asdict(diagnosis.lag) if diagnosis.lag is not None else None,
        "contacts": [{**asdict(one), "sure": one.sure} for one in diagnosis.contacts],
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
        "steps": _steps(diagnosis.tried),
        "error": _misfit(diagnosis.misfit) if diagnosis.misfit is not None else {},
    }


def _unexplained(rest: Unexplained, model: str) -> Record:
    """Return a torque that no effect fits, with the curve that takes it in and what that does."""
    made, curve = rest.consequence, rest.curve
    return {
        "joint": rest.joint,
        "coordinate": rest.coordinate,
        "share": rest.share,
        "evidence_gain": rest.log_bayes_factor,
        "effect": curve.name if curve else None,
        "over": [one.text() for one in curve.over] if curve else [],
        "friction": curve.friction if curve else False,
        "command": curve_command(rest, model),
        "error_before": made.whole_before if made else None,
        "error_after": made.whole_after if made else None,
        "lowers_error": made.worth if made else None,
        **history_of_curve(rest),
    }


def _misfit(misfit: Misfit) -> Record:
    """Return by joint the error on the recording beside that on blocks of the training motion."""
    columns = misfit.own, misfit.here, misfit.whole, misfit.nmse
    names = ("left_out", "inside_range", "whole", "nmse")
    each = zip(misfit.joints, np.stack(columns, axis=1).tolist(), strict=True)
    clear = {misfit.joints[n] for n in misfit.larger}
    return {
        joint: {
            **{n: v for n, v in zip(names, row, strict=True) if np.isfinite(v)},
            "changed": joint in clear,
        }
        for joint, row in each
    }


def check_record(check: Check) -> Record:
    """Return a fault of the measurement; the recording is named if it is one of several."""
    record = {**asdict(check), "values": {name: float(v) for name, v in check.values.items()}}
    record["remedy"] = check.remedy.option if check.remedy else ""
    return {k: v for k, v in record.items() if v or k not in ("source", "remedy")}


def changed_record(changed: Changed) -> Record:
    """Return what changed since a model was identified."""
    return {
        "what": changed.what,
        "joints": list(changed.joints),
        "evidence_gain": changed.log_bayes_factor,
        "p_value": changed.p_value,
        "change": {
            name: {"value": one.value, "unit": one.unit, **_interval(one)}
            for name, one in changed.parameters.items()
        },
        "size": changed.size,
        "error_before": changed.error_before,
        "error_after": changed.error_after,
        "rivals": list(changed.rivals),
        "note": changed.note,
    }


def _interval(estimate: Estimate) -> Record:
    return {"low": estimate.low, "high": estimate.high} if estimate.bounded else {}


def _finding(diagnosis: Diagnosis, found: Found) -> Record:
    effect, made, (before, after) = found.effect, found.consequence, found.errors
    record = {
        "effect": effect.name,
        "joints": list(found.joints),
        "verdict": found.said,
        "holds_on_unseen": found.confirmed,
        "reason": found.doubt.words if found.doubt else "",
        "why": "",
        "evidence_gain": found.log_bayes_factor,
        "p_value": found.p_value,
        "error_before": before,
        "error_after": after,
        "blocks": _blocks(made) if made else [],
        "parameters": {name: asdict(one) for name, one in found.parameters.items()},
        "shape": dict(found.shape),
        "shape_words": effect.shape_words(found.shape, diagnosis.model.joints),
        "formula": effect.formula,
        "meaning": effect.meaning,
        "source": effect.source,
        "ambiguous_with": list(found.rivals),
        "told_apart_by": list(found.told_apart_by),
        "next_motion": effect.next_motion,
    }
    return record | (_of_effect(diagnosis, found) if isinstance(found, Finding) else {})


def _of_effect(diagnosis: Diagnosis, finding: Finding) -> Record:
    """Return the fields that a load or a contact does not have, or else."""
    hold_out = finding.hold_out
    return {
        "caused_by": finding.cause,
        "holds_on_unseen": hold_out.holds,
        "why": reason(finding, diagnosis),
        "size": finding.size,
        "shape_units": {shape.name: shape.unit for shape in finding.effect.shapes},
        "ruled_out_by_unseen": list(finding.ruled_out),
        "trial": {
            "gained": float(np.sum(hold_out.gained)),
            "expected": float(np.sum(hold_out.expected)),
            "ratio": hold_out.ratio,
            "share": hold_out.share,
            "p_value": hold_out.p_value,
        },
        "signature": by_name(finding.partial_residual),
    }


def _blocks(made: Consequence) -> list[dict[str, float]]:
    rows = zip(made.time.tolist(), made.before.tolist(), made.after.tolist(), strict=True)
    return [{"time": time, "before": before, "after": after} for time, before, after in rows]


def _steps(tried: Sequence[tuple[Finding, Consequence]], *, joints: bool = False) -> list[Record]:
    """Return the error of all joints before and after each addition, and of its joint if wanted."""
    if not tried:
        return []
    steps: list[Record] = [{"added": None, "error": tried[0][1].every_before}]
    for finding, made in tried:
        step = {"added": finding.name, "error": made.every_after}
        own = {"joint": made.joint, "before": made.whole_before, "after": made.whole_after}
        steps.append(step | own if joints else step)
    return steps


@dataclass(frozen=True)
class SavedFinding:
    """A finding of a diagnosis' JSON, as far as adding its effect needs it.

    Attributes:
        effect: its name.  joints: their names.  shape: its nonlinear parameters.
        history: the entry of a model's history if it is added: `why`, `verdict`, `evidence_gain`,
            `p_value`; an event of the recording has an empty `why` and is not added.
    """

    effect: str
    joints: tuple[str, ...]
    shape: Mapping[str, float]
    history: Mapping[str, object]

    @property
    def once(self) -> bool:
        """Return whether it is an event of the recording, not a property of the arm."""
        return not self.history["why"]


def saved_findings(text: str) -> tuple[SavedFinding, ...]:
    """Return the findings of a diagnosis' JSON, and what is unexplained as curves.

    Raises:
        ValueError: the text is not the JSON of a diagnosis.
    """
    try:
        held = json.loads(text)
        rest = [one for one in held.get("unexplained", ()) if one.get("effect")]
        curves = [{**one, "joints": [one["joint"]], "shape": {}} for one in rest]
        return tuple(_saved(one) for one in [*held["findings"], *curves])
    except (KeyError, TypeError, AttributeError) as error:
        raise ValueError(f"not the JSON of a diagnosis: {error!r}") from None


def _saved(found: Record) -> SavedFinding:
    first, *rest = map(str, found["joints"])
    shape = {str(name): float(value) for name, value in found["shape"].items()}
    history = {name: found[name] for name in ("why", "verdict", "evidence_gain", "p_value")}
    return SavedFinding(str(found["effect"]), (first, *rest), shape, history)
