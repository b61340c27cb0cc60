"""From a motion to a model: split in time, choose hyperparameters, fit, judge on unseen motion."""

import time
from collections.abc import Sequence
from dataclasses import asdict, dataclass

import numpy as np
from numpy.typing import NDArray

from lagrangian_ff.errors import ModelError, RecordingError
from lagrangian_ff.identification.fit import Choice, Fit, Scaling, fit
from lagrangian_ff.identification.intervals import intervals
from lagrangian_ff.identification.model import Model
from lagrangian_ff.identification.motion_range import MotionRange
from lagrangian_ff.identification.score import Score
from lagrangian_ff.identification.search import TrainingSet, choose, evenly
from lagrangian_ff.identification.spec import Spec, parse
from lagrangian_ff.identification.system import NotPositiveDefiniteError
from lagrangian_ff.kernels import CoupledKernel, States
from lagrangian_ff.progress import Progress, silent
from lagrangian_ff.recording.motion import Motion, concatenate

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

SCALES = ("auto", "joint", "common")
INTERVAL_BLOCK_SECONDS = 1.0
"""Samples closer than this are not counted as independent when intervals are made."""


@dataclass(frozen=True)
class Settings:
    """How a model is identified; the defaults are those of section IV-B but for `train`.

    The paper trains on the first third. A recording of half a minute rarely visits in its first
    third what the rest needs, so two thirds are the default here.

    Attributes:
        model: kernel and effects, e.g. `vrbfs+fri`.
        train: the share of each recording, from its beginning, that is learned from; 1 uses all,
            and the error is then that of blocks left out in turn.
        samples: how many training samples the kernel is built on, evenly spread.
        block_seconds: length of a block of cross-validation, s.
        folds: in how many folds the blocks are left out.
        selection: how hyperparameters are chosen, `validation` or `evidence`.
        scale: how torques are normalised. `common` divides all by one number, so that the joints
            share one Lagrangian, with noise in proportion to each torque's spread; `joint`
            divides each torque by its own spread, right where the joints' units do not agree;
            `auto` tries both and keeps the better one.
        evaluations: how many settings of hyperparameters are tried.
    """

    model: str = "vrbfs+fri"
    train: float = 2.0 / 3.0
    samples: int = 500
    block_seconds: float = 3.0
    folds: int = 5
    selection: str = "validation"
    scale: str = "auto"
    evaluations: int = 90

    def check(self) -> None:
        """Refuse settings that cannot work.

        Raises:
            ModelError: names the setting, what it was and what it may be.
        """
        if not 0.0 < self.train <= 1.0:
            raise ModelError(f"train is {self.train}, expected a share above 0 and at most 1")
        if self.samples < 10:
            raise ModelError(f"samples is {self.samples}, expected at least 10")
        if self.block_seconds <= 0.0:
            raise ModelError(f"block_seconds is {self.block_seconds}, expected above 0 s")
        if self.folds < 2:
            raise ModelError(f"folds is {self.folds}, expected at least 2")
        if self.scale not in SCALES:
            raise ModelError(f"scale is '{self.scale}', expected {', '.join(SCALES)}")


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


def identify(
    motion: Motion | Sequence[Motion],
    settings: Settings | None = None,
    progress: Progress = silent,
) -> Identification:
    """Identify the inverse dynamics of an arm from inputs and outputs alone.

    Args:
        motion: one conditioned recording, or several of the same joints.
        settings: see `Settings`.
        progress: told what is done.

    Raises:
        ModelError: a setting is out of range or the model's name unknown.
        RecordingError: there is less training motion than one block.
    """
    began = time.monotonic()
    settings = settings or Settings()
    settings.check()
    spec = parse(settings.model)
    motions = [motion] if isinstance(motion, Motion) else list(motion)
    training, held_out = split(motions, settings)
    block = training.blocks(settings.block_seconds)
    index = evenly(len(training), settings.samples)
    fine = training.blocks(INTERVAL_BLOCK_SECONDS)[index]
    thinned, block = training.take(index), block[index]
    states = States.of(thinned.q, thinned.qd, thinned.qdd)
    fold = np.unique(block, return_inverse=True)[1] % settings.folds
    data = TrainingSet(states, thinned.tau, fold)
    choice, scaling = choose(
        spec,
        data,
        _scalings(spec, settings, thinned.tau),
        settings.selection,
        settings.evaluations,
        progress,
    )
    progress(1.0, "fitting")
    try:
        fitted = fit(spec, choice, states, thinned.tau, scaling)
    except NotPositiveDefiniteError as error:
        raise ModelError(
            f"the Gram matrix of {len(states)} samples has no Cholesky factor ({error}): "
            "the chosen noise is too small for it; use fewer samples or --selection validation"
        ) from error
    residual, _ = fitted.left_out(data.groups())
    predicted_left_out = thinned.tau - residual
    model = _model(spec, fitted, training, thinned)
    if held_out is None:
        held_out, predicted = thinned, predicted_left_out
        judged = "blocks of the training motion, left out in turn"
    else:
        predicted = model.predict(held_out.q, held_out.qd, held_out.qdd, progress)
        judged = "motion after the training part"
    record = {
        "model": settings.model,
        **Score.of(model.joints, held_out.tau, predicted).record(),
        "judged_on": judged,
        "validation": Score.of(model.joints, thinned.tau, predicted_left_out).record(),
        "samples": len(thinned),
        "seconds": round(time.monotonic() - began, 3),
        "training_seconds": _seconds(training),
        "held_out_seconds": _seconds(held_out),
        "hyperparameters": _hyperparameters(choice, len(states)),
        "scale": "common" if np.ptp(scaling.unit) == 0.0 else "joint",
        "effects": _effects(fitted, model.joints, fine),
        "log_evidence": float(fitted.log_evidence),
        "range": model.range.record(),
        "settings": asdict(settings),
        "sources": [m.source for m in motions],
        "conditioning": dict(training.conditioning),
        "notes": list(training.notes),
    }
    model = _model(spec, fitted, training, thinned, record)
    return Identification(model, record, thinned, held_out, predicted)


def split(motions: Sequence[Motion], settings: Settings) -> tuple[Motion, Motion | None]:
    """The part to learn from and the rest, cut in time in every recording.

    Raises:
        RecordingError: the training part is shorter than one block, or a joint stands still in it.
    """
    parts = [(m, round(settings.train * len(m))) for m in motions]
    training = concatenate([m.take(slice(0, cut)) for m, cut in parts])
    rest = [m.take(slice(cut, len(m))) for m, cut in parts if cut < len(m)]
    if _seconds(training) < settings.block_seconds:
        raise RecordingError(
            f"{training.source}: {_seconds(training):.2f} s of training motion "
            f"({len(training)} samples) is less than one block of {settings.block_seconds:g} s; "
            "record longer, or use a larger --train or a shorter --block"
        )
    return training, concatenate(rest) if rest else None


def _scalings(spec: Spec, settings: Settings, tau: Floats) -> list[Scaling]:
    """The normalisations to try; joints that are learned apart each have their own anyway."""
    per_joint, common = Scaling.of(tau, True), Scaling.of(tau, False)
    if not issubclass(spec.kernel, CoupledKernel):
        return [per_joint]
    return {"auto": [common, per_joint], "joint": [per_joint], "common": [common]}[settings.scale]


def _seconds(motion: Motion) -> float:
    """The time that was recorded, gaps not counted."""
    total = 0.0
    for number in np.unique(motion.segment):
        times = motion.time[motion.segment == number]
        total += float(times[-1] - times[0])
    return round(total, 6)


def _model(
    spec: Spec,
    fitted: Fit,
    training: Motion,
    thinned: Motion,
    record: dict[str, object] | None = None,
) -> Model:
    return Model(
        joints=training.joints,
        name=spec.text,
        kernel=fitted.choice.kernel,
        basis=fitted.basis,
        centres=fitted.states,
        weights=fitted.weights,
        coefficients=fitted.coefficients,
        unit=fitted.scaling.unit,
        range=MotionRange.of(States.of(training.q, training.qd, training.qdd), training.tau),
        record=record or {},
        training_tau=thinned.tau,
        training_time=thinned.time,
        training_segment=thinned.segment,
    )


def _hyperparameters(choice: Choice, samples: int) -> dict[str, object]:
    """By name: a number common to all joints, or a list with one for each."""

    def plain(values: Floats) -> object:
        return float(values[0]) if np.all(values == values[0]) else [float(v) for v in values]

    kernel = {name: plain(v) for name, v in choice.kernel.hyperparameters.items()}
    gamma = choice.noise / samples
    if isinstance(choice.kernel, CoupledKernel):
        gamma = gamma[:1]
    shapes = {
        f"{effect}.{name}": plain(values)
        for effect, named in choice.shapes.items()
        for name, values in named.items()
    }
    return {**kernel, "gamma": plain(gamma), **shapes}


def _effects(fitted: Fit, joints: tuple[str, ...], block: Ints) -> list[dict[str, object]]:
    low, high = intervals(fitted, block)
    value = fitted.coefficients
    found: list[dict[str, object]] = []
    for term, place in fitted.basis.slices():
        parameters = {
            parameter.name: {
                "value": float(value[i]),
                "low": float(low[i]),
                "high": float(high[i]),
                "unit": parameter.unit,
            }
            for parameter, i in zip(
                term.effect.parameters, range(place.start, place.stop), strict=True
            )
        }
        found.append(
            {
                "effect": term.effect.name,
                "joint": joints[term.joint],
                "formula": term.effect.formula,
                "parameters": parameters,
                "shape": dict(term.shape),
            }
        )
    return found
