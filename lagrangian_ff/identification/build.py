"""From chosen hyperparameters to a fitted, judged and recorded model."""

import time
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field

import numpy as np
from numpy.typing import NDArray

from lagrangian_ff.effects import Inputs
from lagrangian_ff.errors import ModelError
from lagrangian_ff.identification.basis import Basis
from lagrangian_ff.identification.calibration import factors, groups
from lagrangian_ff.identification.fit import Choice, Fit, Scaling, fit_basis
from lagrangian_ff.identification.intervals import LEVEL
from lagrangian_ff.identification.mass_matrix import mass_record
from lagrangian_ff.identification.model import Model
from lagrangian_ff.identification.motion_range import MotionRange
from lagrangian_ff.identification.positive import Solution, keep_positive
from lagrangian_ff.identification.records import effect_records, hyperparameter_record
from lagrangian_ff.identification.score import Score
from lagrangian_ff.identification.settings import Settings
from lagrangian_ff.identification.system import NotPositiveDefiniteError
from lagrangian_ff.identification.training import evenly
from lagrangian_ff.kernels import States
from lagrangian_ff.progress import Progress, silent
from lagrangian_ff.recording.motion import Motion

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Bools = NDArray[np.bool_]

POSITIVE_STATES = 1000
"""States along the motion at which the mass matrix is kept positive."""
INTERVAL_BLOCK_SECONDS = 1.0
"""Samples closer than this are not counted as independent when intervals are made."""


@dataclass(frozen=True)
class Blueprint:
    """All that a model is made from.

    Attributes:
        name: kernel and effects.
        choice: the hyperparameters.  scaling: of the torques.  basis: the effects' terms.
        data: the motion learned from and that held out, at the rate that is kept.
        trained: (K,) which of its samples may be learned from.
        index: (C,) those the kernel is built on.
        settings: how all this was chosen.
    """

    name: str
    choice: Choice
    scaling: Scaling
    basis: Basis
    data: Motion
    trained: Bools
    index: Ints
    settings: Settings


@dataclass(frozen=True)
class Identification:
    """What came out.

    Attributes:
        model: ready to predict and to be saved.
        record: the findings as JSON holds them; the page, the node and the file show the same.
        training: the motion learned from, thinned to the samples the kernel is built on.
        held_out: the motion the error was measured on.
        predicted: (M, N) N·m of the model on `held_out`, made without having seen it.
    """

    model: Model
    record: dict[str, object]
    training: Motion
    held_out: Motion
    predicted: Floats
    fitted: Fit = field(repr=False)


def blueprint_of(model: Model) -> Blueprint:
    """What a model was made from."""
    settings = model.record.get("settings")
    known = Settings(**settings) if isinstance(settings, dict) else Settings()
    return Blueprint(
        name=model.name,
        choice=Choice(model.kernel, model.noise, {}),
        scaling=Scaling(model.unit, model.noise_share),
        basis=model.basis,
        data=model.data,
        trained=model.trained,
        index=model.index,
        settings=known,
    )


def blocks(blueprint: Blueprint) -> Ints:
    """(C,) the block of time each sample the kernel is built on lies in, counted from 0."""
    training = blueprint.data.take(blueprint.trained)
    block = np.full(len(blueprint.data), -1)
    block[blueprint.trained] = training.blocks(blueprint.settings.block_seconds)
    return np.asarray(np.unique(block[blueprint.index], return_inverse=True)[1], dtype=np.int64)


def folds(blueprint: Blueprint) -> Ints:
    """(C,) the fold each sample the kernel is built on is left out with."""
    return blocks(blueprint) % blueprint.settings.folds


def calibrated(blueprint: Blueprint, fitted: Fit) -> Floats:
    """(N,) what the deviations of a fit are to be multiplied with; see `calibration`."""
    one_by_one = groups(blocks(blueprint))
    residual, _ = fitted.left_out(one_by_one)
    return factors(residual, fitted.left_out_deviation(one_by_one), independent(blueprint))


def independent(blueprint: Blueprint) -> int:
    """How many samples the kernel is built on are counted as independent."""
    return len(np.unique(blueprint.data.blocks(INTERVAL_BLOCK_SECONDS)[blueprint.index]))


def build(
    blueprint: Blueprint,
    inputs: Inputs,
    facts: Mapping[str, object],
    steps: tuple[Mapping[str, object], ...] = (),
    progress: Progress = silent,
) -> Identification:
    """Fit a model, judge it on motion it has not seen, and write down what was found.

    Args:
        blueprint: what it is made from.
        inputs: all of the data as effects see it.
        facts: what else belongs into the record.
        steps: the model's history before.
        progress: told the share done.

    Raises:
        ModelError: the chosen noise is too small for the arithmetic, or the mass matrix cannot be
            kept positive.
    """
    began = time.monotonic()
    data, index, settings = blueprint.data, blueprint.index, blueprint.settings
    thinned = data.take(index)
    try:
        fitted = fit_basis(
            blueprint.basis, blueprint.choice, inputs.take(index), thinned.tau, blueprint.scaling
        )
    except NotPositiveDefiniteError as error:
        raise ModelError(
            f"the Gram matrix of {len(index)} samples has no Cholesky factor ({error}): "
            "the chosen noise is too small for it; use fewer samples or --selection validation"
        ) from error
    solution = Solution(fitted.states, fitted.weights, fitted.coefficients)
    if settings.positive:
        seen = np.flatnonzero(blueprint.trained)
        along = data.take(seen[evenly(len(seen), POSITIVE_STATES)])
        at = States.of(along.q, along.qd, along.qdd)
        solution = keep_positive(fitted, at, progress)
    residual, _ = fitted.left_out(groups(folds(blueprint)))
    predicted_left_out = thinned.tau - residual
    factor = calibrated(blueprint, fitted)
    training = data.take(blueprint.trained)
    model = Model(
        joints=data.joints,
        name=blueprint.name,
        kernel=fitted.choice.kernel,
        basis=fitted.basis,
        centres=solution.centres,
        weights=solution.weights,
        coefficients=solution.coefficients,
        unit=fitted.scaling.unit,
        range=MotionRange.of(States.of(training.q, training.qd, training.qdd), training.tau),
        record={},
        data=data,
        trained=blueprint.trained,
        index=index,
        noise=blueprint.choice.noise,
        noise_share=blueprint.scaling.noise,
        steps=steps,
    )
    if blueprint.trained.all():
        held_out, predicted = thinned, predicted_left_out
        judged = "blocks of the training motion, left out in turn"
    else:
        held_out = data.take(~blueprint.trained)
        whole = model.predict(
            data.q, data.qd, data.qdd, progress, time=data.time, segment=data.segment
        )
        predicted = whole[~blueprint.trained]
        judged = "motion after the training part"
    fine = data.blocks(INTERVAL_BLOCK_SECONDS)[index]
    score = Score.of(data.joints, held_out.tau, predicted).record()
    scaling = fitted.scaling
    record: dict[str, object] = {
        "model": blueprint.name,
        **score,
        "judged_on": judged,
        "validation": Score.of(data.joints, thinned.tau, predicted_left_out).record(),
        "samples": len(index),
        "seconds": round(time.monotonic() - began, 3),
        "training_seconds": seconds(training),
        "held_out_seconds": seconds(held_out),
        "hyperparameters": hyperparameter_record(blueprint.choice, blueprint.basis, len(index)),
        "scale": "common" if np.ptp(scaling.unit) == 0.0 else "joint",
        "effects": effect_records(fitted, solution.coefficients, data.joints, fine),
        "mass_matrix": mass_record(model),
        "uncertainty": {
            "level": LEVEL,
            "factor": dict(zip(data.joints, factor.tolist(), strict=True)),
        },
        "log_evidence": float(fitted.log_evidence),
        "range": model.range.record(),
        "settings": asdict(settings),
        "conditioning": dict(training.conditioning),
        "notes": list(training.notes),
        **_known(blueprint),
        **facts,
    }
    object.__setattr__(model, "record", record)
    return Identification(model, record, thinned, held_out, predicted, fitted)


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
