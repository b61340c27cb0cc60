"""From a motion to a model: split in time, choose hyperparameters, fit, judge on unseen motion."""

import time
from collections.abc import Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from lagrangian_ff.arrays import Flags, Floats
from lagrangian_ff.effects import Inputs
from lagrangian_ff.errors import ModelError, RecordingError
from lagrangian_ff.identification.blueprint import Blueprint
from lagrangian_ff.identification.build import Identification, build, seconds
from lagrangian_ff.identification.choosing.choose import (
    SHAPED_TORQUES,
    choose,
    choose_robustly,
    weights_beyond,
)
from lagrangian_ff.identification.extending import extend
from lagrangian_ff.identification.history import Step
from lagrangian_ff.identification.memory import require_room
from lagrangian_ff.identification.problem import Problem, Scaling
from lagrangian_ff.identification.samples import EXACT_TORQUES, Samples, decimated, sizes
from lagrangian_ff.identification.settings import SCALES, Settings
from lagrangian_ff.identification.spec import Spec, parse, with_sliding
from lagrangian_ff.kernels import Mechanism, States
from lagrangian_ff.progress import Progress, part, silent
from lagrangian_ff.recording.motion import WITHOUT_GRAVITY, Motion, concatenate

CHOSEN = 0.3
"""Share of the work that choosing hyperparameters takes with inducing points."""

__all__ = ["SCALES", "Identification", "Settings", "identify"]


def identify(
    motion: Motion | Sequence[Motion],
    settings: Settings | None = None,
    progress: Progress = silent,
    mechanism: Mechanism | None = None,
) -> Identification:
    """Identify the inverse dynamics of an arm from inputs and outputs alone.

    Args:
        motion: one conditioned recording, or several of the same joints.
        settings: see `Settings`.
        progress: receives the share done, 0 to 1, and what is done.
        mechanism: prior knowledge of the arm, such as the bodies of a URDF; None is none.

    Raises:
        ModelError: a setting is out of range, the model's name or an effect's joint is unknown; a
            joint cannot slide, see `with_sliding`; or there is not enough memory.
        RecordingError: there is less training motion than one block.
    """
    began = time.monotonic()
    settings = settings or Settings()
    settings.check()
    spec = parse(settings.model)
    motions = [decimated(m) for m in ([motion] if isinstance(motion, Motion) else motion)]
    data = concatenate(motions)
    for effect, joint in spec.further:
        if joint is not None and joint not in data.joints:
            raise ModelError(
                f"model '{spec.text}': {effect.name}@{joint} names no joint of {data.source}, "
                f"which holds {', '.join(data.joints)}"
            )
    spec = with_sliding(spec, settings.prismatic, data, known=mechanism is not None)
    weightless = data.effort == WITHOUT_GRAVITY
    if mechanism is not None:
        mechanism = mechanism.of_joints(data.joints, data.source)
        spec = spec.within(mechanism.without_gravity() if weightless else mechanism)
    spec = replace(spec, weightless=weightless)
    if weightless and not spec.kernel.separates:
        note = (
            f"the effort holds no gravity, but the kernel {spec.kernel.name} cannot leave gravity "
            "out: it may learn some from noise; auto, chain and energy leave it out exactly"
        )
        data = replace(data, notes=(*data.notes, note))
    if settings.positive and not spec.kernel.has_lagrangian:
        raise ModelError(
            f"model '{spec.text}': the joints of {spec.kernel.name} are learned apart and share no "
            "mass matrix that could be kept positive; use auto+fri, chain+fri, energy+fri or "
            "vrbfs+fri"
        )
    trained = _trained(motions, settings)
    learned = trained & ~data.rest.all(axis=1)  # an arm at rest says nothing of its friction
    available = np.flatnonzero(learned if learned.any() else trained)
    width = len(data.joints) if spec.kernel.coupled else 1
    size = sizes(available, settings, width, bool(spec.kernel.differentiable))
    subset = size.subset
    states = States.of(data.q, data.qd, data.qdd)
    inputs = Inputs.of(states, data.time, data.segment, temperature=data.temperature)
    scalings = partial(_scalings, spec, settings)
    samples = Samples(inputs.take(subset), data.tau[subset])
    start = Problem.started(spec, samples, scalings(samples.tau)[0])
    positions = trained, size.centres, size.seen
    blueprint = Blueprint(spec.basic, start.prior, data, *positions, settings)
    require_room(blueprint, len(subset))
    samples = replace(samples, fold=blueprint.folds(subset))
    chosen_at = 1.0 if blueprint.exact else CHOSEN
    share = part(progress, 0.0, chosen_at)
    weight = None
    if settings.loss == "huber":
        chosen, weight = choose_robustly(spec, samples, scalings, settings, share)
        if not blueprint.exact:
            seen = size.seen
            weight = weights_beyond(chosen.problem, weight, inputs.take(seen), data.tau[seen])
    else:
        # An exact model is the fit that its shapes are chosen on.
        shaped = EXACT_TORQUES if blueprint.exact else SHAPED_TORQUES
        chosen = choose(spec, samples, scalings(samples.tau), settings, share, shaped)
    progress(chosen_at, "fitting")
    spec = chosen.spec
    blueprint = replace(blueprint, prior=chosen.problem.prior, name=spec.basic, weight=weight)
    tried, known = chosen.tried, chosen.posterior if blueprint.exact else None
    del chosen  # a fit is as large as the next
    sources = tuple(dict.fromkeys(motion.source for motion in motions))
    found = build(blueprint, inputs, sources, part(progress, chosen_at, 1.0), known)
    del known
    first = Step.between("identified", None, found.model.identified)
    took = round(time.monotonic() - began, 3)
    found = found.with_history((first.record(),), seconds=took, tried=tried)
    for effect, joint in spec.further:
        for name in [joint] if joint else data.joints:
            found = extend(found.model, effect, name, progress=progress)
    return found


def _trained(motions: Sequence[Motion], settings: Settings) -> Flags:
    """Return which samples are learned from: the first share of every recording.

    Raises:
        RecordingError: they are shorter than one block.
    """
    parts = [np.arange(len(m)) < round(settings.train * len(m)) for m in motions]
    first = [m.take(slice(0, int(part.sum()))) for m, part in zip(motions, parts, strict=True)]
    training = concatenate(first)
    if seconds(training) < settings.block_seconds:
        raise RecordingError(
            f"{training.source}: {seconds(training):.2f} s of training motion "
            f"({len(training)} samples) is less than one block of {settings.block_seconds:g} s; "
            "record longer, or use a larger --train or a shorter --block"
        )
    return np.concatenate(parts)


def _scalings(
    spec: Spec, settings: Settings, tau: Floats, weight: Floats | None = None
) -> list[Scaling]:
    """Return the normalisations to try; joints that are learned apart each have their own."""
    per_joint, common = (Scaling.of(tau, each, weight) for each in (True, False))
    if spec.kernel.mechanism is not None:
        if settings.scale == "joint":
            raise ModelError(
                "scale is 'joint', but what is known of a mechanism is known of all joints in one "
                "unit; use auto or common, and bring efforts to N·m with --effort-scale"
            )
        return [common]
    if not spec.kernel.coupled:
        return [per_joint]
    if settings.positive:
        return [common]
    return {"auto": [common, per_joint], "joint": [per_joint], "common": [common]}[settings.scale]
