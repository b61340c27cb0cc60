"""From chosen hyperparameters to a fitted, judged and recorded model."""

import time
from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from lagrangian_ff.effects import Inputs
from lagrangian_ff.errors import ModelError
from lagrangian_ff.identification.blueprint import Blueprint
from lagrangian_ff.identification.certainty.calibration import calibrated
from lagrangian_ff.identification.certainty.few import QUICK, Few
from lagrangian_ff.identification.certainty.intervals import LEVEL
from lagrangian_ff.identification.certainty.outliers import doubtful, outlier_record
from lagrangian_ff.identification.mechanics.mass_matrix import mass_record
from lagrangian_ff.identification.mechanics.positive import Expansion, keep_positive
from lagrangian_ff.identification.model import Model
from lagrangian_ff.identification.motion_range import MotionRange
from lagrangian_ff.identification.records import effect_records, hyperparameter_record
from lagrangian_ff.identification.samples import evenly
from lagrangian_ff.identification.score import Score
from lagrangian_ff.identification.solve import Solved, solve
from lagrangian_ff.identification.solving.fit import Fit
from lagrangian_ff.identification.solving.solution import NotPositiveDefiniteError
from lagrangian_ff.kernels import States
from lagrangian_ff.progress import Progress, part, silent
from lagrangian_ff.recording.motion import Motion

Floats = NDArray[np.float64]

POSITIVE_STATES = 1000
"""States along the motion at which the mass matrix is kept positive."""


@dataclass(frozen=True)
class Identification:
    """What came out.

    Attributes:
        model: ready to predict and to be saved.
        record: the findings as JSON holds them; the page, the node and the file show the same.
        training: the motion learned from, thinned to the samples used.
        held_out: the motion the error was measured on.
        predicted: (M, N) N·m of the model on `held_out`, made without having seen it.
    """

    model: Model
    record: dict[str, object]
    training: Motion
    held_out: Motion
    predicted: Floats
    fitted: Fit = field(repr=False)


def build(
    blueprint: Blueprint,
    inputs: Inputs,
    facts: Mapping[str, object],
    steps: tuple[Mapping[str, object], ...] = (),
    progress: Progress = silent,
    known: Fit | None = None,
) -> Identification:
    """Fit a model, judge it on motion it has not seen, and write down what was found.

    Args:
        blueprint: what it is made from.
        inputs: all of the data as effects see it.
        facts: what else belongs into the record.
        steps: the model's history before.
        progress: told the share done.
        known: the fit, where it is known already.

    Raises:
        ModelError: no noise makes the Gram matrix fit for the arithmetic, or the mass matrix cannot
            be kept positive.
    """
    began = time.monotonic()
    data, learned = blueprint.data, blueprint.data.take(blueprint.seen)
    solved = (
        Solved(known, known, None, known.choice.noise, ())
        if known
        else solve(blueprint, inputs, part(progress, 0.0, 0.8))
    )
    fitted = solved.fitted
    expansion = _expansion(blueprint, fitted, part(progress, 0.8, 0.9))
    residual, _ = fitted.left_out(blueprint.folded)
    left_out = learned.tau - residual
    training = data.take(blueprint.trained)
    believed, trust = training.tau, None
    if solved.threshold is not None:
        trust = fitted.trust
        believed = np.where(doubtful(trust), 0.0, learned.tau)
    model = Model(
        joints=data.joints,
        name=blueprint.name,
        kernel=fitted.choice.kernel,
        basis=fitted.basis,
        centres=expansion.centres,
        weights=expansion.weights,
        coefficients=expansion.coefficients,
        unit=fitted.scaling.unit,
        range=MotionRange.of(States.of(training.q, training.qd, training.qdd), believed),
        record={},
        data=data,
        trained=blueprint.trained,
        index=blueprint.index,
        seen=blueprint.seen,
        noise=solved.noise,
        noise_share=blueprint.scaling.noise,
        steps=steps,
        trust=trust,
    )
    if blueprint.trained.all():
        held_out, predicted = learned, left_out
        judged = "blocks of the training motion, left out in turn"
    else:
        held_out = data.take(~blueprint.trained)
        share = part(progress, 0.9, 1.0)
        states = data.q, data.qd, data.qdd
        whole = model.predict(*states, share, time=data.time, segment=data.segment)
        predicted = whole[~blueprint.trained]
        judged = "motion after the training part"
    met, _ = solved.weighed.left_out(blueprint.apart)
    factor = calibrated(blueprint, solved, met).tolist()
    quick = _quick_factor(replace(blueprint, trust=trust), inputs, solved, met)
    values = expansion.coefficients
    record: dict[str, object] = {
        "model": blueprint.name,
        **Score.of(data.joints, held_out.tau, predicted).record(),
        "judged_on": judged,
        "validation": Score.of(data.joints, learned.tau, left_out).record(),
        "samples": len(learned),
        "landmarks": 0 if blueprint.exact else len(blueprint.index),
        "seconds": round(time.monotonic() - began, 3),
        "training_seconds": seconds(training),
        "held_out_seconds": seconds(held_out),
        "hyperparameters": hyperparameter_record(fitted.choice, blueprint.basis, len(learned)),
        "scale": "common" if np.ptp(fitted.scaling.unit) == 0.0 else "joint",
        "effects": effect_records(solved.weighed, values, data.joints, blueprint.seconds),
        "mass_matrix": mass_record(model),
        "uncertainty": {
            "level": LEVEL,
            "factor": dict(zip(data.joints, factor, strict=True)),
            "quick": quick,
        },
        "log_evidence": float(fitted.log_evidence),
        "range": model.range.record(),
        "settings": blueprint.settings.record(),
        "conditioning": dict(training.conditioning),
        "notes": [*training.notes, *solved.notes],
        **_known(blueprint),
        **facts,
    }
    if solved.threshold is not None:
        missed = held_out.tau - predicted
        record["outliers"] = outlier_record(
            fitted.trust, solved.threshold, learned, residual, missed
        )
    object.__setattr__(model, "record", record)
    return Identification(model, record, learned, held_out, predicted, fitted)


def _expansion(blueprint: Blueprint, fitted: Fit, progress: Progress) -> Expansion:
    """What the torque is made of: as fitted, or with its mass matrix kept positive."""
    if not blueprint.settings.positive:
        return Expansion(fitted.states, fitted.weights, fitted.coefficients)
    seen = np.flatnonzero(blueprint.trained)
    along = blueprint.data.take(seen[evenly(len(seen), POSITIVE_STATES)])
    return keep_positive(fitted, States.of(along.q, along.qd, along.qdd), progress)


def _quick_factor(
    blueprint: Blueprint, inputs: Inputs, solved: Solved, met: Floats
) -> dict[str, float] | None:
    """Of certainty's cheap form, by joint, so that asking it later costs nothing; None without."""
    choice = replace(blueprint.choice, noise=solved.noise)
    x = inputs.take(blueprint.seen)
    few = Few(replace(blueprint, choice=choice), x, solved.weighed.trust, QUICK)
    try:
        few.fit()  # which is what will be asked
        factor = few.factor(met)
    except (ModelError, NotPositiveDefiniteError):
        return None
    if not np.isfinite(factor).all():
        return None
    return dict(zip(blueprint.data.joints, factor.tolist(), strict=True))


def _known(blueprint: Blueprint) -> dict[str, object]:
    mechanism = blueprint.choice.kernel.mechanism
    return {"mechanism": mechanism.record()} if mechanism else {}


def seconds(motion: Motion) -> float:
    """The time that was recorded, gaps not counted."""
    total = 0.0
    for number in np.unique(motion.segment):
        times = motion.time[motion.segment == number]
        total += float(times[-1] - times[0])
    return round(total, 6)
