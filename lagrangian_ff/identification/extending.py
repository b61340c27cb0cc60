"""A model with one more effect, refitted from the data that it keeps."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from lagrangian_ff.arrays import Floats
from lagrangian_ff.effects import Effect, Inputs
from lagrangian_ff.effects.curve import Curve
from lagrangian_ff.errors import ModelError
from lagrangian_ff.identification.basis import Basis, Term
from lagrangian_ff.identification.blueprint import Blueprint
from lagrangian_ff.identification.build import Identification, build
from lagrangian_ff.identification.choosing.left_out import fold_errors, surely_less
from lagrangian_ff.identification.choosing.shapes import best_shape, fall, refit_shapes
from lagrangian_ff.identification.choosing.smoothness import smooth, without_bounds
from lagrangian_ff.identification.history import Reason, Step
from lagrangian_ff.identification.memory import require_room
from lagrangian_ff.identification.model import Model
from lagrangian_ff.identification.solving.posterior import Posterior, exact
from lagrangian_ff.progress import Progress, part, silent
from lagrangian_ff.record_json import read

NOISE_FACTORS = (0.03, 0.1, 0.3, 2.0)
"""Factors on the noise, tried once the new effect explains more of the torque."""
NOISE_SAMPLES = 240
SAME = 1e-6
"""Share of an effect that must lie outside the model's basis for it to count as another effect."""


def extend(
    model: Model,
    effect: Effect,
    joint: str,
    shape: Mapping[str, float] | None = None,
    why: Mapping[str, object] | None = None,
    progress: Progress = silent,
) -> Identification:
    """Add an effect to one joint of a model and refit it.

    The kernel keeps its hyperparameters. The effect was part of the noise: that changes where the
    error on blocks left out in turn surely falls. The shapes of the joint's friction, which had
    made up for the effect, are chosen again.

    Args:
        model: with the data it keeps.  joint: name of its joint.
        effect: to add; a curve that is not made yet gets the smoothness of largest evidence.
        shape: nonlinear parameters, kept as given; the others are searched.
        why: fields for the model's history that give the reason.
        progress: receives the share done, 0 to 1.

    Raises:
        ModelError: there is no such joint, the model has the effect, or an equal one, already, a
            curve is over what does not move, or there is not enough memory.
    """
    if joint not in model.joints:
        raise ModelError(f"the model has no joint '{joint}'; it has {', '.join(model.joints)}")
    number = model.joints.index(joint)
    there = [t.effect.name for t in model.basis.terms if t.joint == number]
    if effect.name in there:
        raise ModelError(
            f"the model has {effect.name} on {joint} already ({model.name}); one is enough"
        )
    given = dict(shape or {})
    if not model.kernel.coupled and effect.others(number, {s.name: s.start for s in effect.shapes}):
        raise ModelError(
            f"{effect.name} acts on several joints, which {model.kernel.name} learns apart; use "
            "auto+fri, chain+fri or vrbfs+fri"
        )
    old = Blueprint.of(model)
    inputs = model.inputs_of(model.data)
    subset = old.subset(inputs)
    require_room(old, len(subset.samples))
    progress(0.1, f"adding {effect.name}")
    before = exact(subset)
    wish = effect if isinstance(effect, Curve) and not effect.axes else None
    learned = inputs.take(np.flatnonzero(old.trained))
    if wish is not None:
        effect = smooth(before, wish, number, learned)
    term = Term(effect, number, best_shape(before, effect, number, given))
    _, own = fall(before, term)
    if own < SAME:
        raise ModelError(
            f"{effect.name} on {joint} is a torque that the model has already under another name "
            f"({', '.join(there)}): "
            "adding it would change nothing"
        )
    kept = [(effect.name, name) for name in given]
    basis = refit_shapes(before, Basis((*old.prior.basis.terms, term)), number, kept)
    del before  # its factor is as large as that of the fit to come
    inputs = replace(inputs, sign_speed=basis.sign_speed(inputs.joints))
    prior = replace(old.prior, basis=basis)
    new = replace(old, name=f"{model.name}+{effect.name}@{joint}", prior=prior)
    progress(0.3, "choosing the noise")
    new = replace(new, prior=replace(prior, noise=_best_noise(new, inputs)))
    if wish is not None:  # its torque was noise when its smoothness was chosen
        new = _smoother(new, inputs, wish, learned)
    progress(0.6, "fitting")
    then = model.identified
    again = any(t.effect.uses for t in new.prior.basis.terms)
    done = 0.8 if again else 1.0
    found = build(new, inputs, then.sources, part(progress, 0.6, done))
    if again:
        inputs = found.model.inputs_of(found.model.data)
        found = build(new, inputs, then.sources, part(progress, done, 1.0))
    while (fewer := _bounded(found.posterior)) is not None:
        new = replace(new, prior=replace(new.prior, basis=fewer))
        found = build(new, inputs, then.sources, part(progress, done, 1.0))
    reason = read(Reason, why or {})
    step = Step.between(f"{effect.name} on {joint}", then, found.model.identified, reason)
    progress(1.0, "fitting")
    return found.with_history((*model.steps, step.record()))


def without(model: Model, effect: Effect, joint: str) -> Model:
    """Return a model without an effect on a joint, refitted; the noise is chosen again.

    Its history keeps the effect: this is for a comparison, not to be saved.
    """
    old, number = Blueprint.of(model), model.joints.index(joint)
    kept = [t for t in model.basis.terms if (t.effect.name, t.joint) != (effect.name, number)]
    inputs = model.inputs_of(model.data)
    prior = replace(old.prior, basis=Basis(tuple(kept)))
    less = replace(old, prior=prior)
    return build(replace(less, prior=replace(prior, noise=_best_noise(less, inputs))), inputs).model


def _smoother(blueprint: Blueprint, inputs: Inputs, wish: Curve, learned: Inputs) -> Blueprint:
    """Return a blueprint whose last term, a curve, has the smoothness that suits its noise."""
    *terms, last = blueprint.prior.basis.terms
    without = replace(blueprint, prior=replace(blueprint.prior, basis=Basis(tuple(terms))))
    effect = smooth(exact(without.subset(inputs)), wish, last.joint, learned)
    basis = Basis((*terms, replace(last, effect=effect)))
    return replace(blueprint, prior=replace(blueprint.prior, basis=basis))


def _bounded(found: Posterior) -> Basis | None:
    """Return the basis without the steps of monotone curves that are at 0; None if none is."""
    smaller: dict[int, Term] = {}
    for _, own, solution in found.systems:
        less = without_bounds(solution, own)
        if less is not None:
            smaller |= {id(a): b for a, b in zip(own.terms, less.terms, strict=True)}
    basis = found.problem.basis
    return Basis(tuple(smaller.get(id(t), t) for t in basis.terms)) if smaller else None


def _best_noise(blueprint: Blueprint, inputs: Inputs) -> Floats:
    """Return (N,) the noise, or a multiple of it with surely a smaller error on blocks left out.

    One factor for all joints: more weight to one alone pulls the kernel, which all share, away from
    the others. The worst known joints decide. Chance must not: less noise that it brings makes the
    joints of large torque follow theirs.
    """
    problem = blueprint.subset(inputs, NOISE_SAMPLES)

    def logs(factor: float) -> Floats:
        return np.asarray(np.log(np.nanmean(fold_errors(problem.noisier(factor)), axis=1)))

    folds = {factor: logs(factor) for factor in (1.0, *NOISE_FACTORS)}
    best = min(folds, key=lambda factor: float(np.mean(folds[factor])))
    return problem.noisier(best if surely_less(folds[best], folds[1.0]) else 1.0).noise
