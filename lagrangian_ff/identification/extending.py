"""A model with one more effect, refitted from the data that it keeps."""

from collections.abc import Mapping
from dataclasses import replace
from datetime import datetime, timezone

import numpy as np
from numpy.typing import NDArray

from lagrangian_ff.effects import Effect, Inputs
from lagrangian_ff.errors import ModelError
from lagrangian_ff.identification.basis import Basis, Term
from lagrangian_ff.identification.blueprint import Blueprint
from lagrangian_ff.identification.build import Identification, build
from lagrangian_ff.identification.choice import Choice
from lagrangian_ff.identification.choosing.search import validation_score
from lagrangian_ff.identification.choosing.shapes import best_shape, fall, tuned
from lagrangian_ff.identification.memory import require_room
from lagrangian_ff.identification.model import Model
from lagrangian_ff.identification.solving.equations import fit_basis
from lagrangian_ff.identification.solving.solution import NotPositiveDefiniteError
from lagrangian_ff.progress import Progress, part, silent

Floats = NDArray[np.float64]

NOISE_FACTORS = (0.03, 0.1, 0.3, 1.0, 2.0)
"""What the noise is multiplied with when less of the torque is left unexplained."""
NOISE_SAMPLES = 240
SAME = 1e-6
"""Share of an effect that the model must not hold already for it to be another effect."""


def extend(
    model: Model,
    effect: Effect,
    joint: str,
    shape: Mapping[str, float] | None = None,
    why: Mapping[str, object] | None = None,
    progress: Progress = silent,
) -> Identification:
    """Add an effect to one joint of a model and refit it.

    The kernel keeps its hyperparameters; the noise, which the effect was part of, is chosen
    anew, by blocks left out in turn. So are the shapes of the joint's friction, which had made up
    for the effect.

    Args:
        model: with the data it keeps.
        effect: what is added.
        joint: where.
        shape: nonlinear parameters, kept as given; what is not given is searched.
        why: what the model's history shall tell of the reason.
        progress: told the share done.

    Raises:
        ModelError: there is no such joint, the model has the effect, or an equal one, already, or
            there is not enough memory.
    """
    number = joint_number(model, joint)
    require_new(model, effect, number)
    old = Blueprint.of(model)
    inputs = model.inputs_of_data()
    few = old.few(inputs)
    require_room(old, len(few.x))
    progress(0.1, f"adding {effect.name}")
    before = fit_basis(old.basis, old.choice, few.x, few.tau, old.scaling, few.trust)
    given = dict(shape or {})
    term = Term(effect, number, best_shape(before, effect, number, few.x, given))
    _, own = fall(before, term, few.x)
    if own < SAME:
        raise ModelError(
            f"{effect.name} on {joint} is a torque that the model has already under another name "
            f"({', '.join(t.effect.name for t in model.basis.terms if t.joint == number)}): "
            "adding it would change nothing"
        )
    kept = [(effect.name, name) for name in given]
    basis = tuned(before, Basis((*old.basis.terms, term)), number, few.x, kept)
    del before  # its factor is as large as that of the fit to come
    inputs = replace(inputs, sign_speed=basis.sign_speed(inputs.joints))
    new = replace(old, name=f"{model.name}+{effect.name}@{joint}", basis=basis)
    progress(0.3, "choosing the noise anew")
    new = replace(new, choice=_with_noise(new, inputs))
    progress(0.6, "fitting")
    facts = {"sources": model.record.get("sources", [])}
    again = any(t.effect.uses for t in new.basis.terms)
    done = 0.8 if again else 1.0
    found = build(new, inputs, facts, model.steps, part(progress, 0.6, done))
    if again:
        seen = found.model.inputs_of_data()
        found = build(new, seen, facts, model.steps, part(progress, done, 1.0))
    step = step_record(f"{effect.name} on {joint}", model.record, found.record, why)
    object.__setattr__(found.model, "steps", (*model.steps, step))
    progress(1.0, "fitting")
    return found


def step_record(
    added: str,
    before: Mapping[str, object] | None,
    after: Mapping[str, object],
    why: Mapping[str, object] | None = None,
) -> dict[str, object]:
    """One line of a model's history."""

    def rmse(record: Mapping[str, object], joint: str) -> float:
        joints = record["joints"]
        assert isinstance(joints, Mapping)
        return float(joints[joint]["rmse"])

    joints = after["joints"]
    assert isinstance(joints, Mapping)
    return {
        "added": added,
        "when": datetime.now(timezone.utc).isoformat(timespec="seconds"),
        "error_before": before["rmse"] if before else None,
        "error_after": after["rmse"],
        "joints": {
            name: {
                "before": rmse(before, name) if before else None,
                "after": rmse(after, name),
            }
            for name in joints
        },
        "judged_on": after["judged_on"],
        **(why or {}),
    }


def joint_number(model: Model, joint: str) -> int:
    """The index of a joint.

    Raises:
        ModelError: the model has no such joint; lists those it has.
    """
    if joint not in model.joints:
        raise ModelError(f"the model has no joint '{joint}'; it has {', '.join(model.joints)}")
    return model.joints.index(joint)


def require_new(model: Model, effect: Effect, joint: int) -> None:
    """Refuse an effect that the model has on the joint.

    Raises:
        ModelError: it has; says so.
    """
    if any(t.effect.name == effect.name and t.joint == joint for t in model.basis.terms):
        raise ModelError(
            f"the model has {effect.name} on {model.joints[joint]} already "
            f"({model.name}); one is enough"
        )


def _with_noise(blueprint: Blueprint, inputs: Inputs) -> Choice:
    """The choice whose noise leaves the smallest error on blocks left out."""
    data = blueprint.few(inputs, NOISE_SAMPLES)
    best, cost = blueprint.choice, np.inf
    for factor in NOISE_FACTORS:
        choice = replace(blueprint.choice, noise=blueprint.choice.noise * factor)
        try:
            fitted = fit_basis(
                blueprint.basis, choice, data.x, data.tau, blueprint.scaling, data.trust
            )
            score = float(np.nanmean(validation_score(fitted, data.groups())))
        except (NotPositiveDefiniteError, np.linalg.LinAlgError):
            continue
        if score < cost:
            best, cost = choice, score
    return best
