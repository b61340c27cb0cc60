"""From a motion to a model: split in time, choose hyperparameters, fit, judge on unseen motion."""

import time
from collections.abc import Sequence
from dataclasses import replace
from functools import partial

import numpy as np
from numpy.typing import NDArray

from lagrangian_ff.effects import Inputs
from lagrangian_ff.errors import ModelError, RecordingError
from lagrangian_ff.identification.blueprint import Blueprint
from lagrangian_ff.identification.build import Identification, build, seconds
from lagrangian_ff.identification.choice import Scaling
from lagrangian_ff.identification.choosing.choose import SHAPED_TORQUES, choose_all
from lagrangian_ff.identification.choosing.robustly import choose_robustly, trust_beyond
from lagrangian_ff.identification.choosing.search import starting_choice
from lagrangian_ff.identification.choosing.training import TrainingSet
from lagrangian_ff.identification.extending import extend, step_record
from lagrangian_ff.identification.keeping import kept
from lagrangian_ff.identification.memory import require_room
from lagrangian_ff.identification.settings import SCALES, Settings
from lagrangian_ff.identification.sizing import EXACT_TORQUES, sizes
from lagrangian_ff.identification.sliding import with_sliding
from lagrangian_ff.identification.spec import Spec, parse
from lagrangian_ff.kernels import CoupledKernel, LagrangianKernel, Mechanism, States
from lagrangian_ff.progress import Progress, part, silent
from lagrangian_ff.recording.motion import Motion, concatenate

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]

CHOSEN = 0.3
"""Share of the work after which hyperparameters are chosen, where the model is on landmarks."""

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
        progress: told what is done.
        mechanism: what is known of the arm before, as the bodies of a URDF; None is nothing.

    Raises:
        ModelError: a setting is out of range, the model's name unknown, or an effect stands at a
            joint that is not there; a joint cannot be said to slide, see `with_sliding`; or there
            is not enough memory for the model.
        RecordingError: there is less training motion than one block.
    """
    began = time.monotonic()
    settings = settings or Settings()
    settings.check()
    spec = parse(settings.model)
    motions = [kept(m) for m in ([motion] if isinstance(motion, Motion) else motion)]
    data = concatenate(motions)
    _require_joints(spec, data)
    spec = with_sliding(spec, settings.prismatic, data, known=mechanism is not None)
    if mechanism is not None:
        mechanism = mechanism.of_joints(data.joints, data.source)
        spec = spec.within(mechanism)
    if settings.positive:
        _require_lagrangian(spec)
    trained = _trained(motions, settings)
    available = np.flatnonzero(trained)
    width = len(data.joints) if issubclass(spec.kernel, CoupledKernel) else 1
    size = sizes(available, settings, width)
    few = size.few
    states = States.of(data.q, data.qd, data.qdd)
    inputs = Inputs.of(states, data.time, data.segment)
    start = starting_choice(spec, States.of(data.q[few], data.qd[few], data.qdd[few]))
    scalings = partial(_scalings, spec, settings)
    blueprint = Blueprint(
        name=spec.basic,
        choice=start,
        scaling=scalings(data.tau[few])[0],
        basis=start.basis(spec, len(data.joints)),
        data=data,
        trained=trained,
        index=size.centres,
        seen=size.seen,
        settings=settings,
    )
    require_room(blueprint, len(few))
    training = TrainingSet(inputs.take(few), data.tau[few], blueprint.folds(few))
    chosen_at = 1.0 if blueprint.exact else CHOSEN
    how = settings.selection, settings.evaluations, part(progress, 0.0, chosen_at)
    trust = None
    if settings.loss == "huber":
        chosen, trust = choose_robustly(spec, training, scalings, *how)
        if not blueprint.exact:
            seen = size.seen
            trust = trust_beyond(chosen, training, trust, inputs.take(seen), data.tau[seen])
    else:
        # An exact model is the fit that its shapes are chosen on.
        shaped = EXACT_TORQUES if blueprint.exact else SHAPED_TORQUES
        chosen = choose_all(spec, training, scalings(training.tau), *how, shaped)
    progress(chosen_at, "fitting")
    choice, spec = chosen.choice, chosen.spec
    blueprint = replace(
        blueprint,
        name=spec.basic,
        choice=choice,
        scaling=chosen.scaling,
        basis=choice.basis(spec, len(data.joints)),
        trust=trust,
    )
    facts = {
        "sources": [m.source for m in motions],
        "tried": list(chosen.tried),
    }
    known = chosen.fitted if blueprint.exact else None
    del chosen  # a fit is as large as the next
    told = part(progress, chosen_at, 1.0)
    found = build(blueprint, inputs, facts, progress=told, known=known)
    del known
    found.record["seconds"] = round(time.monotonic() - began, 3)
    object.__setattr__(found.model, "steps", (step_record("identified", None, found.record),))
    for effect, joint in spec.further:
        for name in [joint] if joint else data.joints:
            found = extend(found.model, effect, name, progress=progress)
    return found


def _require_joints(spec: Spec, data: Motion) -> None:
    for effect, joint in spec.further:
        if joint is not None and joint not in data.joints:
            raise ModelError(
                f"model '{spec.text}': {effect.name}@{joint} names no joint of {data.source}, "
                f"which holds {', '.join(data.joints)}"
            )


def _require_lagrangian(spec: Spec) -> None:
    if not issubclass(spec.kernel, LagrangianKernel):
        raise ModelError(
            f"model '{spec.text}': the joints of {spec.kernel.name} are learned apart and share no "
            "mass matrix that could be kept positive; use auto+fri, chain+fri, energy+fri or "
            "vrbfs+fri"
        )


def _trained(motions: Sequence[Motion], settings: Settings) -> Bools:
    """Which samples are learned from: the first share of every recording.

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
    spec: Spec, settings: Settings, tau: Floats, trust: Floats | None = None
) -> list[Scaling]:
    """The normalisations to try; joints that are learned apart each have their own anyway."""
    per_joint, common = (Scaling.of(tau, each, trust) for each in (True, False))
    if spec.kernel.mechanism is not None:
        if settings.scale == "joint":
            raise ModelError(
                "scale is 'joint', but what is known of a mechanism is known of all joints in one "
                "unit; use auto or common, and bring efforts to N·m with --effort-scale"
            )
        return [common]
    if not issubclass(spec.kernel, CoupledKernel):
        return [per_joint]
    if settings.positive:
        return [common]
    return {"auto": [common, per_joint], "joint": [per_joint], "common": [common]}[settings.scale]
