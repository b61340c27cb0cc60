"""Adding effects to a model: one by name, or what a diagnosis confirmed; and the consequences."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

from lagrangian_ff.diagnosis import thresholds
from lagrangian_ff.diagnosis.confidence import Doubt, Reason, Verdict
from lagrangian_ff.diagnosis.consequence import Consequence, consequence_of, errors_of
from lagrangian_ff.diagnosis.results import Diagnosis, Finding, Unexplained, sorted_findings
from lagrangian_ff.diagnosis.sentences import history_of_curve, no_help, reason
from lagrangian_ff.effects import EFFECTS, Effect, Over, curve_over
from lagrangian_ff.effects.curve import NAME as CURVE
from lagrangian_ff.errors import EffectError, ModelError
from lagrangian_ff.identification import Model, extend, without
from lagrangian_ff.progress import Progress, silent
from lagrangian_ff.recording.motion import Motion

MOST_CURVES = 2
"""Torques without an explanation that are tried as a curve."""
MOST = 4
"""Findings for which the model is refitted, and all confirmed ones; others have no consequence."""


def add(
    model: Model,
    effect: str,
    joint: str,
    shape: Mapping[str, float] | None = None,
    why: Mapping[str, object] | None = None,
    progress: Progress = silent,
    *,
    over: Sequence[str] = (),
    friction: bool = False,
    odd: bool = False,
    monotone: bool = False,
) -> Model:
    """Return the model with one more effect, refitted from the data that it keeps.

    Args:
        model: with its data.  joint: where it acts.
        effect: a name of the catalogue, or `curve` for one without a formula.
        shape: nonlinear parameters; those not given are searched.
        why: for the history: `why`, `verdict`, `evidence_gain`, `p_value`.
        progress: receives the share done, 0 to 1.
        over: the one or two coordinates of a curve, such as `velocity` or `position@joint_2`.
        friction, odd, monotone: of a curve: whether it changes sign with the direction of motion,
            with its first coordinate, and whether it only rises or only falls.

    Raises:
        EffectError: there is no such effect or coordinate.
        ModelError: there is no such joint, the model has the effect or its equal already, or a
            curve is over what does not move.
    """
    if effect == CURVE:
        of = [Over.of(text, model.joints) for text in over]
        wish = curve_over(of, friction=friction, odd=odd, monotone=monotone)
        return extend(model, wish, joint, None, why, progress).model
    if over or friction or odd or monotone:
        raise EffectError(f"{effect} has a form of its own: only a {CURVE} is over a coordinate")
    if effect not in EFFECTS:
        raise EffectError(
            f"there is no effect '{effect}'; there are {', '.join(EFFECTS)} and {CURVE} "
            "(lagrangian_ff effects lists them)"
        )
    return extend(model, EFFECTS[effect], joint, shape, why, progress).model


def history(model: Model) -> dict[str, object]:
    """Return the steps of a model for JSON: what was added, why, and the error before and after."""
    return {"model": model.name, "steps": [dict(step) for step in model.steps]}


def apply(diagnosis: Diagnosis, progress: Progress = silent, *, curves: bool = False) -> Model:
    """Return the model with all confirmed findings, added one by one, each with its reason.

    Only confirmed findings that lower the error are added; without any the result is the same
    model. A load or a contact belongs to the recording, not to the arm, and is not added.

    Args:
        diagnosis: with its consequences no model is fitted again.
        progress: receives the share done, 0 to 1.
        curves: whether to add, as curves, what is unexplained and lowers the error so.
    """
    waiting = any(not one.once for one in diagnosis.confirmed) and not diagnosis.tried
    untried = curves and all(one.consequence is None for one in diagnosis.unexplained)
    if waiting or (untried and diagnosis.unexplained):
        diagnosis = with_consequences(diagnosis, progress)
    if curves and diagnosis.curves:
        return diagnosis.curves[-1][1].model
    return diagnosis.tried[-1][1].model if diagnosis.tried else diagnosis.model


def with_consequences(
    diagnosis: Diagnosis, progress: Progress = silent, *, confirmed_only: bool = False
) -> Diagnosis:
    """Return the diagnosis with what each finding does to the error.

    The confirmed ones are added one after the other. While much is still missing, the model makes
    up for it, and a true effect may raise the error of another joint: such a one is judged again
    beside all others. One that does not lower the error then is left out, and no more than
    suggested; the rest is judged again without it. Findings that are not confirmed are tried
    beside those that are kept; an ambiguous one that does not help is no more than suggested
    either. What is unexplained is tried as a curve, one after the other, after those that are kept.

    Args:
        progress: receives the share done, 0 to 1.
        confirmed_only: whether to try the confirmed ones alone: a third to a half of the work.
    """
    kept = [one for one in diagnosis.findings if one.confirmed and not one.once]
    others = [one for one in diagnosis.findings if not one.confirmed][: max(0, MOST - len(kept))]
    others, most_curves = ([], 0) if confirmed_only else (others, MOST_CURVES)
    whole = len(kept) + len(others) + min(most_curves, len(diagnosis.unexplained))
    done = 0

    def extended(model: Model, finding: Finding | Unexplained) -> Model | None:
        nonlocal done
        effect: Effect | None
        if isinstance(finding, Finding):
            effect, shape, why = finding.effect, finding.shape, for_history(finding, diagnosis)
        else:
            effect, shape, why = finding.curve, {}, history_of_curve(finding)
        if effect is None:
            return None
        progress(done / whole, f"adding {effect.name} to see the error fall")
        done = min(done + 1, whole)
        try:
            return extend(model, effect, finding.joint, shape, why).model
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
        error = errors_of(model, motion)
        for finding in findings[same:]:
            larger = extended(model, finding)
            if larger is None:
                made.append(replace(finding, consequence=None))
                continue
            new = errors_of(larger, motion)
            consequence = consequence_of(larger, motion, finding.joints, error, new)
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
    error = errors_of(model, motion)
    suggested: list[Finding] = []
    for finding in others:
        larger = extended(model, finding)
        if larger is not None:
            new = errors_of(larger, motion)
            made = consequence_of(larger, motion, finding.joints, error, new)
            finding = replace(finding, consequence=made)
            if finding.verdict is Verdict.AMBIGUOUS and not made.worth:
                finding = _useless(finding)
        suggested.append(finding)
    curves: list[Unexplained] = []
    for rest in diagnosis.unexplained:
        larger = extended(model, rest) if len(curves) < most_curves else None
        if larger is not None:
            new = errors_of(larger, motion)
            made = consequence_of(larger, motion, (rest.joint,), error, new)
            rest = replace(rest, consequence=made)
            if made.worth:
                model, error = larger, new
        curves.append(rest)
    by_name = {_key(one): one for one in (*useful, *dropped, *suggested)}
    findings = [by_name.get(_key(one), one) for one in diagnosis.findings]
    progress(1.0, "adding what was found")
    ordered = sorted_findings(findings)
    return replace(diagnosis, findings=ordered, unexplained=tuple(curves))


def _alone(finding: Finding) -> Finding:
    """Return a finding whose consequence is not judged beside others."""
    made = finding.consequence
    return replace(finding, consequence=replace(made, beside=None)) if made else finding


def _useless(finding: Finding) -> Finding:
    """Return a finding that was tried as no more than suggested, since it does not help."""
    made = finding.consequence
    assert made is not None
    words = no_help(made.beside or made)
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
    error = errors_of(model, motion)
    useful, useless = list(tried), []
    for finding in reversed(tried):
        made = finding.consequence
        if made is None or _helps(finding, made):
            continue
        if len(useful) > 1:
            less = without(model, finding.effect, finding.joint)
            before = errors_of(less, motion)
            beside = consequence_of(model, motion, finding.joints, before, error)
            made = replace(made, beside=beside)
        place = useful.index(finding)
        finding = replace(finding, consequence=made)
        if _helps(finding, made):
            useful[place] = finding
            continue
        useless.append(_useless(finding))
        if len(useful) > 1:
            model, error = less, before
        del useful[place]
    return useful, useless, model


def _helps(finding: Finding, made: Consequence) -> bool:
    """Return whether a finding is worth adding.

    For one that stands the evidence of this motion will do, searched and unseen together, or else
    the error: of many motions the search holds a part. But the error must not surely rise.
    """
    if not finding.stands:
        return made.worth
    nats = finding.log_bayes_factor + float(finding.hold_out.gained.sum())
    return not made.harms and (nats > thresholds.USED.floor or made.worth)


def for_history(finding: Finding, diagnosis: Diagnosis) -> dict[str, object]:
    """Return the entry of a model's history for a finding that was added."""
    return {
        "why": reason(finding, diagnosis),
        "verdict": finding.verdict.value,
        "evidence_gain": finding.log_bayes_factor,
        "p_value": finding.p_value,
    }
