"""Adding effects to a model: one by name, or what a diagnosis confirmed; and the consequences."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from lagrangian_ff.arrays import Floats
from lagrangian_ff.diagnosis.compare import compare
from lagrangian_ff.diagnosis.consequence import Consequence
from lagrangian_ff.diagnosis.results import (
    Diagnosis,
    Doubt,
    Finding,
    Reason,
    Verdict,
    sorted_findings,
)
from lagrangian_ff.diagnosis.sentences import no_help, reason
from lagrangian_ff.effects import EFFECTS
from lagrangian_ff.errors import EffectError, ModelError
from lagrangian_ff.identification import Model, extend, without
from lagrangian_ff.progress import Progress, silent
from lagrangian_ff.recording.motion import Motion

BLOCK_SECONDS = 3.0
MOST = 4
"""Findings for which the model is refitted, and all confirmed ones; others have no consequence."""


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

    Only confirmed findings that lower the error are added; without any the result is the same
    model. A load or a contact belongs to the recording, not to the arm, and is not added.

    Args:
        diagnosis: with its consequences no model is fitted again.
        progress: receives the share done, 0 to 1.
    """
    if any(not one.once for one in diagnosis.confirmed) and not diagnosis.tried:
        diagnosis = with_consequences(diagnosis, progress)
    return diagnosis.tried[-1][1].model if diagnosis.tried else diagnosis.model


def with_consequences(diagnosis: Diagnosis, progress: Progress = silent) -> Diagnosis:
    """Return the diagnosis with what each finding does to the error.

    The confirmed ones are added one after the other. While much is still missing, the model makes
    up for it, and a true effect may raise the error of another joint: such a one is judged again
    beside all others. One that does not lower the error then is left out, and no more than
    suggested; the rest is judged again without it. Findings that are not confirmed are tried
    beside those that are kept; an ambiguous one that does not help is no more than suggested
    either.
    """
    kept = [one for one in diagnosis.findings if one.confirmed and not one.once]
    others = [one for one in diagnosis.findings if not one.confirmed][: max(0, MOST - len(kept))]
    whole, done = len(kept) + len(others), 0

    def extended(model: Model, finding: Finding) -> Model | None:
        nonlocal done
        progress(done / whole, f"adding {finding.effect.name} to see the error fall")
        done = min(done + 1, whole)
        why = for_history(finding, diagnosis)
        try:
            return extend(model, finding.effect, finding.joint, finding.shape, why).model
        except ModelError:  # the model has it by another name, or one before made it superfluous
            return None

    def chain(
        findings: Sequence[Finding], before: Sequence[Finding] = ()
    ) -> tuple[list[Finding], Model]:
        """Add findings one after the other, those that began an earlier chain not again."""
        alike = [_key(a) == _key(b) for a, b in zip(findings, before, strict=False)]
        same = alike.index(False) if False in alike else len(alike)
        model, made = diagnosis.model, [_alone(finding) for finding in findings[:same]]
        model = next((f.consequence.model for f in reversed(made) if f.consequence), model)
        error = _errors(model, motion)
        for finding in findings[same:]:
            larger = extended(model, finding)
            if larger is None:
                made.append(replace(finding, consequence=None))
                continue
            new = _errors(larger, motion)
            consequence = _between(larger, motion, finding.joint, error, new)
            made.append(replace(finding, consequence=consequence))
            model, error = larger, new
        return made, model

    motion = diagnosis.held_out
    tried, model = chain(kept)
    useful, useless, model = _worth(tried, model, motion)
    dropped = useless
    while useless:
        tried, model = chain(useful, tried)
        useful, useless, model = _worth(tried, model, motion)
        dropped += useless
    error = _errors(model, motion)
    suggested = []
    for finding in others:
        larger = extended(model, finding)
        if larger is not None:
            new = _errors(larger, motion)
            made = _between(larger, motion, finding.joint, error, new)
            finding = replace(finding, consequence=made)
            if finding.verdict is Verdict.AMBIGUOUS and not made.worth:
                finding = _useless(finding)
        suggested.append(finding)
    by_name = {_key(one): one for one in (*useful, *dropped, *suggested)}
    findings = [by_name.get(_key(one), one) for one in diagnosis.findings]
    progress(1.0, "adding what was found")
    return replace(diagnosis, findings=sorted_findings(findings))


def _alone(finding: Finding) -> Finding:
    """Return a finding whose consequence is not judged beside others."""
    made = finding.consequence
    return replace(finding, consequence=replace(made, beside=None)) if made else finding


def _useless(finding: Finding) -> Finding:
    """Return a finding that was tried as no more than suggested, since it does not help."""
    made = finding.consequence
    assert made is not None
    words = no_help(made.beside or made, finding.joint)
    return replace(finding, doubt=Doubt(Reason.NO_HELP, words))


def _key(finding: Finding) -> tuple[str, tuple[str, ...]]:
    return finding.effect.name, finding.joints


def _worth(
    tried: Sequence[Finding], model: Model, motion: Motion
) -> tuple[list[Finding], list[Finding], Model]:
    """Return the findings that lower the error, those that do not, and the model with the former.

    Args:
        tried: with their consequences, one added after the other; those without have none.
        model: with all of them.
    """
    error = _errors(model, motion)
    useful, useless = list(tried), []
    for finding in reversed(tried):
        made = finding.consequence
        if made is None or made.worth:
            continue
        if len(useful) > 1:
            less = without(model, finding.effect, finding.joint)
            before = _errors(less, motion)
            made = replace(made, beside=_between(model, motion, finding.joint, before, error))
        place = useful.index(finding)
        finding = replace(finding, consequence=made)
        if made.worth:
            useful[place] = finding
            continue
        useless.append(_useless(finding))
        if len(useful) > 1:
            model, error = less, before
        del useful[place]
    return useful, useless, model


def _errors(model: Model, motion: Motion) -> Floats:
    """Return (M, N) N·m that a model misses."""
    return compare(model, motion).residual


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
    falls = (blocks[0] ** 2 - blocks[1] ** 2) * counts
    scatter = float(np.sum((falls - counts * falls.sum() / counts.sum()) ** 2))
    scatter *= len(counts) / max(1, len(counts) - 1)
    squares = float(np.sum(before[:, column] ** 2))
    each = [dict(zip(model.joints, map(rms, one.T), strict=True)) for one in (before, after)]
    return Consequence(
        model,
        motion.elapsed[starts],
        *blocks,
        *whole,
        rms(before),
        rms(after),
        float(np.sqrt(scatter)) / squares if squares > 0.0 else 0.0,
        each[0],
        each[1],
    )


def for_history(finding: Finding, diagnosis: Diagnosis) -> dict[str, object]:
    """Return the entry of a model's history for a finding that was added."""
    return {
        "why": reason(finding, diagnosis),
        "verdict": finding.verdict.value,
        "evidence_gain": finding.log_bayes_factor,
        "p_value": finding.p_value,
    }
