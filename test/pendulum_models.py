"""Models of the double pendulum, fitted with hyperparameters given: nothing is searched."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pendulum

from lagrangian_ff.effects import Inputs
from lagrangian_ff.identification import Identification, Settings
from lagrangian_ff.identification.basis import Basis, Term
from lagrangian_ff.identification.blueprint import Blueprint
from lagrangian_ff.identification.build import build
from lagrangian_ff.identification.problem import Problem, Scaling
from lagrangian_ff.identification.samples import Samples, evenly
from lagrangian_ff.identification.spec import parse
from lagrangian_ff.kernels import States
from lagrangian_ff.recording.motion import Motion


def fitted(
    name: str,
    motion: Motion | None = None,
    further: Sequence[Term] = (),
    per_joint: bool = False,
    noise: float = 1e-4,
    in_turn: bool = False,
    **settings: object,
) -> Identification:
    """Fit and judge a model.

    Args:
        name: kernel and effects.
        motion: what it is of; a minute's half of the pendulum where none is given.
        further: effects besides those of the name.
        per_joint: whether each torque is divided by its own spread.
        noise: its variance relative to the kernel's prior variance.
        in_turn: whether every fifth block is held out, in place of the last part.
        settings: what differs from the defaults.
    """
    data = motion or pendulum.motion(30.0, noise=0.01)
    wanted = replace(Settings(name, samples=150, train=0.8), **settings)  # type: ignore[arg-type]
    trained = np.arange(len(data)) < round(wanted.train * len(data))
    if in_turn:
        trained = data.blocks(wanted.block_seconds) % 5 != 2
    index = np.flatnonzero(trained)[evenly(int(trained.sum()), wanted.samples)]
    centres = seen = index
    if wanted.landmarks:
        seen = np.flatnonzero(trained)
        centres = seen[evenly(len(seen), wanted.landmarks)]
    states, spec = States.of(data.q, data.qd, data.qdd), parse(name)
    inputs = Inputs.of(states, data.time, data.segment)
    samples, scaling = (
        Samples(inputs.take(index), data.tau[index]),
        Scaling.of(data.tau[index], per_joint),
    )
    start = Problem.started(spec, samples, scaling).with_relative_noise(np.array([noise]))
    blueprint = Blueprint(
        name=spec.basic,
        prior=replace(start.prior, basis=Basis((*start.basis.terms, *further))),
        data=data,
        trained=trained,
        index=centres,
        seen=seen,
        settings=wanted,
    )
    return build(blueprint, inputs)
