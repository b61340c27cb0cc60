"""Formulas for a torque that no effect of the catalogue explains, each judged as an effect is."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from lagrangian_ff.arrays import Floats
from lagrangian_ff.diagnosis import thresholds
from lagrangian_ff.diagnosis.confidence import Doubt, Reason, Verdict
from lagrangian_ff.diagnosis.consequence import Consequence, consequence_of, errors_of, rms
from lagrangian_ff.diagnosis.diagnose import searched_and_unseen
from lagrangian_ff.diagnosis.proposing.grammar import Form, forms
from lagrangian_ff.diagnosis.results import Finding
from lagrangian_ff.diagnosis.search.bayes_factor import (
    BayesFactor,
    bayes_factors,
    best_shape,
    log_bayes_factor_of,
)
from lagrangian_ff.diagnosis.search.candidates import named, nonparametric
from lagrangian_ff.diagnosis.search.forward import Search
from lagrangian_ff.diagnosis.search.judging import (
    Step,
    candidates_of,
    evidence_without,
    explained_with,
    judge,
)
from lagrangian_ff.diagnosis.search.significance import MaximumNull, best_of_each, rivals
from lagrangian_ff.diagnosis.sentences import no_help
from lagrangian_ff.diagnosis.verdicts import findings_of
from lagrangian_ff.diagnosis.whitening import Whitened, fit_for
from lagrangian_ff.effects import Curve, Effect, Over
from lagrangian_ff.effects.formula import Formula
from lagrangian_ff.errors import ModelError
from lagrangian_ff.identification import Model, extend, without
from lagrangian_ff.identification.basis import Basis
from lagrangian_ff.progress import Progress, part, silent
from lagrangian_ff.recording.motion import Motion

PROMISING = 24
"""Formulas that are looked closer at."""
PROPOSED = 3
"""Formulas that are judged on unseen motion and proposed, at most."""


@dataclass(frozen=True, eq=False)
class Proposal:
    """A formula for what is missing on a joint.

    Attributes:
        finding: its verdict, parameters, evidence and consequence, as that of an effect.
        words: what it might be.
    """

    finding: Finding
    words: str

    @property
    def name(self) -> str:
        """Return the name of its effect."""
        return self.finding.effect.name

    @property
    def formula(self) -> str:
        """Return the torque, with parameters and shapes by their names."""
        return self.finding.effect.formula

    def record(self) -> dict[str, Any]:
        """Return the formula as a file of effects holds it."""
        effect = self.finding.effect
        assert isinstance(effect, Formula)
        return {**effect.stored(), "meaning": self.words}


@dataclass(frozen=True, eq=False)
class Proposals:
    """The formulas proposed for one joint, best first.

    Attributes:
        joint: its name.  proposals: the formulas.
        tried: how many formulas and shapes competed.
        threshold: nats that the best of all candidates exceeds by chance once in twenty times.
        curve: log Bayes factor of the best curve on the joint, nats.
        curve_error: N·m of the model with the curve that it holds, on the unseen motion; None
            without one.
        confirmed_on: the unseen motion, in words.
    """

    joint: str
    proposals: tuple[Proposal, ...]
    tried: int
    threshold: float
    curve: float
    curve_error: float | None
    confirmed_on: str

    def record(self) -> dict[str, Any]:
        """Return the formulas as a file of effects holds them."""
        return {"effects": [one.record() for one in self.proposals]}


def propose(
    model: Model,
    motion: Motion | Sequence[Motion],
    confirm: Motion | Sequence[Motion] = (),
    joint: str | None = None,
    over: Sequence[str] = (),
    progress: Progress = silent,
) -> Proposals:
    """Return formulas for what a model lacks on a joint, or for the curve that it has there.

    A curve of the joint in the model is taken out, and formulas compete to replace it.

    Args:
        motion, confirm: see `diagnose`.
        joint: where; None is the joint with a curve, or with most evidence of something missing.
        over: coordinates that the formulas may be of, see `add`; all if none is named.
        progress: receives the share done, 0 to 1.

    Raises:
        ModelError, RecordingError: as by `diagnose`; or there is no such joint.
        EffectError: there is no such coordinate.
    """
    if joint is not None and joint not in model.joints:
        raise ModelError(f"the model has no joint '{joint}'; it has {', '.join(model.joints)}")
    of = [Over.of(text, model.joints) for text in over]
    first, unseen, separate = searched_and_unseen(model, motion, confirm)
    place = None if joint is None else model.joints.index(joint)
    curves = [t for t in model.basis.terms if isinstance(t.effect, Curve)]
    if place is None and curves:
        place = curves[-1].joint
    replaced = [term for term in curves if term.joint == place]
    kept = Basis(tuple(t for t in model.basis.terms if t not in replaced))
    whitened = fit_for(model, first, kept, part(progress, 0.0, 0.2))
    progress(0.2, "looking at curves")
    place = _worst(whitened) if place is None else place
    where = model.joints[place]
    found = {one.effect.name: one for one in forms(whitened.x, place, model.joints, of)}
    if not found:
        raise ModelError(f"no coordinate of {where} that is allowed moves: there is no formula")
    looked = _looked(whitened, found, place, part(progress, 0.25, 0.6))
    progress(0.6, "confirming on unseen motion")
    findings = [_finding(one, looked, unseen, model) for one in looked.best]
    base = model
    for term in replaced:
        base = without(base, term.effect, where)
    before = errors_of(base, unseen)
    judged = []
    for number, finding in enumerate(findings):
        progress(0.7 + 0.3 * number / len(findings), f"adding {finding.effect.name}")
        judged.append(_with_consequence(finding, base, unseen, before))
    progress(1.0, "proposing")
    words = {name: form.words for name, form in found.items()}
    error = rms(errors_of(model, unseen)[:, place]) if replaced else None
    return Proposals(
        where,
        tuple(Proposal(one, words[one.effect.name](one.shape)) for one in _sorted(judged)),
        looked.tried,
        looked.null.threshold,
        looked.curve,
        error,
        unseen.source if separate else "the end of it, held back",
    )


@dataclass(frozen=True, eq=False)
class _Looked:
    """The formulas on one joint after a closer look.

    Attributes:
        without: the motion with hyperparameters that suit the best, and nothing explained.
        best: the best formulas, best first, each with its shape refined.
        names: all that were looked closer at.
        tried: how many candidates there were.  null: of the maximum over all of them.
        firsts: log Bayes factor of each formula before the refit, by name.
        evidence: the best log evidence that is reached without any of them.
        curve: log Bayes factor of the best curve.
    """

    without: Whitened
    best: tuple[BayesFactor, ...]
    names: tuple[BayesFactor, ...]
    tried: int
    null: MaximumNull
    firsts: dict[str, float]
    evidence: float
    curve: float


def _worst(whitened: Whitened) -> int:
    """Return the joint on which a curve gains most."""
    found = bayes_factors(whitened, nonparametric(whitened.x, range(whitened.joints)), coarse=True)
    whitened.forget()
    return max(found, key=lambda score: score.log_bf).candidate.joint


def _looked(whitened: Whitened, found: dict[str, Form], joint: int, progress: Progress) -> _Looked:
    effects: dict[str, Effect] = {name: one.effect for name, one in found.items()}
    candidates = candidates_of(whitened, range(whitened.joints), effects)
    progress(0.0, f"trying {len(candidates)} formulas and curves")
    scores = bayes_factors(whitened, candidates, coarse=True)
    whitened.forget()
    null = MaximumNull.of(scores)
    best = best_of_each(scores)
    here = [one for one in best if one.candidate.joint == joint]
    promising = [one for one in here if one.candidate.named][:PROMISING]
    few = {one.candidate.source.name: one.candidate.effect for one in promising}
    progress(0.5, "looking closer at the best of them")
    step, refitted = judge(whitened, here[0], here, null, few)
    less = refitted if step is not None else whitened
    names = named(less.x, less.basis, [joint], few)
    on_grid: dict[tuple[str, int], list[BayesFactor]] = {}
    for one in bayes_factors(less, names):
        on_grid.setdefault(one.candidate.key, []).append(one)
    again = [best_shape(less, some) for some in on_grid.values()]
    curves = bayes_factors(less, nonparametric(less.x, [joint]))
    less.forget()
    sizes = {name: len(one.candidates(less.x, joint)) for name, one in few.items()}
    again.sort(key=lambda one: np.log(sizes[one.candidate.source.name]) - one.log_bf)
    return _Looked(
        less,
        tuple(again[:PROPOSED]),
        tuple(again),
        len(candidates),
        null,
        {one.candidate.source.name: one.log_bf for one in promising},
        max(evidence_without(whitened), less.system.log_evidence, whitened.system.log_evidence),
        max((one.log_bf for one in curves), default=0.0),
    )


def _finding(score: BayesFactor, looked: _Looked, unseen: Motion, model: Model) -> Finding:
    """Return the finding of one formula, as if it were the step of a search."""
    less, candidate = looked.without, score.candidate
    log_bf = min(score.log_bf, log_bayes_factor_of(score, less, looked.evidence))
    others = [one for one in looked.names if one.candidate.key != candidate.key]
    step = Step(
        replace(score, log_bf=log_bf),
        tuple(rivals(score, others)),
        looked.firsts[candidate.source.name],
        looked.null.p_value(looked.firsts[candidate.source.name]),
        None,
    )
    explained = less.explaining(*explained_with(less, candidate))
    left = bayes_factors(explained, nonparametric(less.x, [candidate.joint]))
    explained.forget()
    every = looked.names
    own = len(less.basis.terms)
    search = Search((step,), every, every, tuple(left), looked.null, None, explained, own)
    (finding,) = findings_of(search, unseen, model, None)
    limits = thresholds.USED
    if finding.doubt is None and (log_bf <= limits.floor or step.p_value > limits.level):
        words = (
            f"it gains {log_bf:.0f} nats of evidence, and chance as much (p = {step.p_value:.2g})"
        )
        return replace(finding, doubt=Doubt(Reason.NOT_HELD_OUT, words))
    return finding


def _sorted(findings: Sequence[Finding]) -> list[Finding]:
    """Return the findings by verdict, among equals the most nats of all motion first."""
    order = list(Verdict)

    def key(one: Finding) -> tuple[int, float]:
        return order.index(one.verdict), -one.log_bayes_factor - float(one.hold_out.gained.sum())

    return sorted(findings, key=key)


def _with_consequence(finding: Finding, base: Model, unseen: Motion, before: Floats) -> Finding:
    try:
        larger = extend(base, finding.effect, finding.joint, finding.shape).model
    except ModelError:  # the model has it by another name
        return finding
    after = errors_of(larger, unseen)
    made: Consequence = consequence_of(larger, unseen, finding.joints, before, after)
    finding = replace(finding, consequence=made)
    if finding.doubt is None and not made.worth:
        return replace(finding, doubt=Doubt(Reason.NO_HELP, no_help(made)))
    return finding
