"""Adding effects to a model: one by name, or what a diagnosis confirmed; and the consequences."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from lagrangian_ff.arrays import Floats
from lagrangian_ff.diagnosis.compare import compare
from lagrangian_ff.diagnosis.results import Consequence, Diagnosis, Finding
from lagrangian_ff.diagnosis.sentences import reason
from lagrangian_ff.effects import EFFECTS
from lagrangian_ff.errors import EffectError, ModelError
from lagrangian_ff.identification import Model, extend
from lagrangian_ff.progress import Progress, silent
from lagrangian_ff.recording.motion import Motion

BLOCK_SECONDS = 3.0
MOST = 4
"""Findings for which the model is refitted; the others have no consequence."""


def add(
    model: Model,
    effect: str,
    joint: str,
    shape: Mapping[str, float] | None = None,
    why: Mapping[str, object] | None = None,
    progress: Progress = silent,
) -> Model:
    """Return the model with one more effect, refitted from the data that it keeps.

    Args:
        model: with its data.  effect: a name of the catalogue.  joint: where it acts.
        shape: nonlinear parameters; those not given are searched.
        why: for the history: `why`, `verdict`, `evidence_gain`, `p_value`.
        progress: receives the share done, 0 to 1.

    Raises:
        EffectError: there is no such effect.
        ModelError: there is no such joint, or the model has the effect or its equal already.
    """
    if effect not in EFFECTS:
        raise EffectError(
            f"there is no effect '{effect}'; there are {', '.join(EFFECTS)} "
            "(lagrangian_ff effects lists them)"
        )
    return extend(model, EFFECTS[effect], joint, shape, why, progress).model


def history(model: Model) -> dict[str, object]:
    """Return the steps of a model for JSON: what was added, why, and the error before and after."""
    return {"model": model.name, "steps": [dict(step) for step in model.steps]}


def apply(diagnosis: Diagnosis, progress: Progress = silent) -> Model:
    """Return the model with all confirmed findings, added one by one, each with its reason.

    Only confirmed findings are added; without any the result is the same model. A load or a
    contact belongs to the recording, not to the arm, and is not added.

    Args:
        diagnosis: with its consequences no model is fitted again.
        progress: receives the share done, 0 to 1.
    """
    model = diagnosis.model
    lasting = [one for one in diagnosis.confirmed if not one.once]
    if diagnosis.tried and len(lasting) == len(diagnosis.confirmed):
        model = diagnosis.tried[-1][1].model
        lasting = [one for one in lasting if one.consequence is None]
    for one in lasting:
        why = for_history(one, diagnosis)
        try:
            model = add(model, one.effect.name, one.joint, one.shape, why, progress)
        except ModelError:  # one before it has made it superfluous
            continue
    return model


def with_consequences(diagnosis: Diagnosis, progress: Progress = silent) -> Diagnosis:
    """Return the diagnosis with what each finding does to the error.

    Each is added to the model and the confirmed ones before it. Findings that are not confirmed are
    tried, and left out again.
    """
    model, motion = diagnosis.model, diagnosis.held_out
    error = compare(model, motion).residual
    tried = list(diagnosis.findings)
    count = min(len(tried), MOST)
    for number, finding in enumerate(diagnosis.findings[:MOST]):
        progress(number / count, f"adding {finding.effect.name} to see the error fall")
        try:
            why = for_history(finding, diagnosis)
            larger = extend(model, finding.effect, finding.joint, finding.shape, why).model
        except ModelError:
            continue
        new = compare(larger, motion).residual
        made = _between(larger, motion, finding.joint, error, new)
        tried[number] = replace(finding, consequence=made)
        if finding.confirmed:
            model, error = larger, new
    progress(1.0, "adding what was found")
    return replace(diagnosis, findings=tuple(tried))


def _between(
    model: Model, motion: Motion, joint: str, before: Floats, after: Floats
) -> Consequence:
    """Return the consequence with a larger model, of residuals (M, N) before and after."""
    column = model.joints.index(joint)
    block = motion.blocks(BLOCK_SECONDS)
    starts = np.flatnonzero(np.diff(block, prepend=-1))
    counts = np.diff([*starts, len(block)])

    def by_block(error: Floats) -> Floats:
        sums = np.add.reduceat(error[:, column] ** 2, starts)
        return np.asarray(np.sqrt(sums / counts))

    def rms(error: Floats) -> float:
        return float(np.sqrt(np.mean(error**2)))

    blocks = by_block(before), by_block(after)
    whole = rms(before[:, column]), rms(after[:, column])
    return Consequence(model, motion.elapsed[starts], *blocks, *whole, rms(before), rms(after))


def for_history(finding: Finding, diagnosis: Diagnosis) -> dict[str, object]:
    """Return the entry of a model's history for a finding that was added."""
    return {
        "why": reason(finding, diagnosis),
        "verdict": finding.verdict.value,
        "evidence_gain": finding.log_bayes_factor,
        "p_value": finding.p_value,
    }
