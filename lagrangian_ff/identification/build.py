"""From chosen hyperparameters to a solved, judged and recorded model."""

import time
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from lagrangian_ff.arrays import Floats
from lagrangian_ff.effects import Inputs
from lagrangian_ff.errors import ModelError
from lagrangian_ff.identification.blueprint import Blueprint, Solved, solve
from lagrangian_ff.identification.certainty.calibration import (
    LEVEL,
    QUICK,
    SubsetOfData,
    calibrated,
)
from lagrangian_ff.identification.findings import (
    effects_of,
    hyperparameters_of,
    mass_check,
    outliers_found,
)
from lagrangian_ff.identification.mechanics.positive import Expansion, keep_positive
from lagrangian_ff.identification.model import Model
from lagrangian_ff.identification.predicting import MotionRange
from lagrangian_ff.identification.records import Calibration, Identified, KnownMechanism, Score
from lagrangian_ff.identification.samples import evenly
from lagrangian_ff.identification.solving.posterior import Posterior
from lagrangian_ff.identification.solving.robust import outliers_of
from lagrangian_ff.identification.solving.solution import NotPositiveDefiniteError
from lagrangian_ff.kernels import States
from lagrangian_ff.progress import Progress, part, silent
from lagrangian_ff.record_json import read
from lagrangian_ff.recording.motion import Conditioning, Motion
from lagrangian_ff.sampling import recorded_seconds

POSITIVE_STATES = 1000
"""States along the motion at which the mass matrix is kept positive."""


@dataclass(frozen=True)
class Identification:
    """A model with its record and the motion it was judged on.

    Attributes:
        model: ready to predict and to be saved.
        training: the motion learned from, thinned to the samples used.
        held_out: the motion the error was measured on.
        predicted: (M, N) N·m of the model on `held_out`, made without having seen it.
    """

    model: Model
    training: Motion
    held_out: Motion
    predicted: Floats
    posterior: Posterior = field(repr=False)

    @property
    def record(self) -> Mapping[str, object]:
        """Return the findings as JSON holds them, in the model's file too."""
        return self.model.record

    def with_history(
        self, steps: tuple[Mapping[str, object], ...], **facts: Any
    ) -> "Identification":
        """Return the same with another history of the model, and more facts in its findings."""
        record = replace(self.model.identified, **facts).record()
        return replace(self, model=replace(self.model, record=record, steps=steps))


def build(
    blueprint: Blueprint,
    inputs: Inputs,
    sources: tuple[str, ...] = (),
    progress: Progress = silent,
    known: Posterior | None = None,
) -> Identification:
    """Fit a model, judge it on motion it has not seen, and record the findings.

    Args:
        inputs: all of the data as effects see it.
        sources: names of the recordings.
        progress: receives the share done, 0 to 1.
        known: the posterior, if it was solved already.

    Raises:
        ModelError: no noise makes the Gram matrix positive definite, or the mass matrix cannot be
            kept positive.
    """
    began = time.monotonic()
    data, learned = blueprint.data, blueprint.data.take(blueprint.seen)
    solved = Solved(known, known, None, known.problem.prior, ()) if known else None
    solved = solved or solve(blueprint, inputs, part(progress, 0.0, 0.8))
    posterior = solved.posterior
    problem = posterior.problem
    expansion: Posterior | Expansion = posterior
    if blueprint.settings.positive:
        trained = np.flatnonzero(blueprint.trained)
        along = data.take(trained[evenly(len(trained), POSITIVE_STATES)])
        at = States.of(along.q, along.qd, along.qdd)
        expansion = keep_positive(posterior, at, part(progress, 0.8, 0.9))
    residual = posterior.left_out(blueprint.folded)
    left_out = learned.tau - residual
    training = data.take(blueprint.trained)
    reliable, weight = training.tau, None
    if solved.threshold is not None:
        weight = problem.samples.weights
        reliable = np.where(outliers_of(weight), 0.0, learned.tau)
    known_range = MotionRange.of(States.of(training.q, training.qd, training.qdd), reliable)
    known_range, bounded = known_range.without_wild_torque(data.joints, learned.tau, left_out)
    draft = Model(
        joints=data.joints,
        name=blueprint.name,
        # The noise of a model on inducing points is raised joint by joint; a refit begins below.
        prior=replace(problem.prior, noise=solved.prior.noise),
        centres=expansion.states,
        weights=expansion.weights,
        coefficients=expansion.coefficients,
        range=known_range,
        record={},
        data=data,
        trained=blueprint.trained,
        index=blueprint.index,
        seen=blueprint.seen,
        irls_weight=weight,
    )
    if blueprint.trained.all():
        held_out, predicted = learned, left_out
        judged = "blocks of the training motion, left out in turn"
    else:
        held_out = data.take(~blueprint.trained)
        share = part(progress, 0.9, 1.0)
        states = data.q, data.qd, data.qdd
        whole = draft.predict(*states, share, time=data.time, segment=data.segment)
        predicted = whole[~blueprint.trained]
        judged = "motion after the training part"
    apart = solved.weighed.left_out(blueprint.apart)
    factor = calibrated(blueprint, solved, apart).tolist()
    quick = _quick_factor(replace(blueprint, weight=weight), inputs, solved, apart)
    values, mechanism = expansion.coefficients, blueprint.prior.kernel.mechanism
    outliers = None
    if solved.threshold is not None:
        missed = held_out.tau - predicted
        weights = problem.samples.weights
        outliers = outliers_found(weights, solved.threshold, learned, residual, missed)
    found = Identified(
        model=blueprint.name,
        score=Score.of(data.joints, held_out.tau, predicted),
        judged_on=judged,
        validation=Score.of(data.joints, learned.tau, left_out),
        samples=len(learned),
        landmarks=0 if blueprint.exact else len(blueprint.index),
        seconds=round(time.monotonic() - began, 3),
        training_seconds=seconds(training),
        held_out_seconds=seconds(held_out),
        hyperparameters=hyperparameters_of(problem.having(basis=blueprint.prior.basis)),
        scale="common" if np.ptp(problem.unit) == 0.0 else "joint",
        effects=effects_of(solved.weighed, values, data.joints, blueprint.seconds),
        mass_matrix=mass_check(draft),
        uncertainty=Calibration(LEVEL, dict(zip(data.joints, factor, strict=True)), quick),
        log_evidence=float(posterior.log_evidence),
        range=draft.range,
        settings=blueprint.settings,
        conditioning=Conditioning.from_record(training.conditioning),
        notes=(*training.notes, *solved.notes, *bounded),
        mechanism=read(KnownMechanism, mechanism.record()) if mechanism else None,
        sources=sources,
        outliers=outliers,
    )
    model = replace(draft, record=found.record())
    return Identification(model, learned, held_out, predicted, posterior)


def _quick_factor(
    blueprint: Blueprint, inputs: Inputs, solved: Solved, left_out: Floats
) -> dict[str, float] | None:
    """Return the calibration of the cheap uncertainty by joint; None if it cannot be made."""
    x = inputs.take(blueprint.seen)
    weights = solved.weighed.problem.samples.weights
    subset = SubsetOfData(replace(blueprint, prior=solved.prior), x, weights, QUICK)
    try:
        subset.fit()  # the later use of the model must not fail
        factor = subset.factor(left_out)
    except (ModelError, NotPositiveDefiniteError):
        return None
    if not np.isfinite(factor).all():
        return None
    return dict(zip(blueprint.data.joints, factor.tolist(), strict=True))


def seconds(motion: Motion) -> float:
    """Return the time that was recorded in s, gaps not counted."""
    return round(recorded_seconds(motion.time, motion.segment), 6)
