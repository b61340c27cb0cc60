"""From a blueprint to a fit: exactly or on landmarks, with the loss that was asked for.

Where the Gram matrix has no factor it gets more noise.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from lagrangian_ff.effects import Inputs
from lagrangian_ff.errors import ModelError
from lagrangian_ff.identification.blueprint import Blueprint
from lagrangian_ff.identification.solving.equations import Equations
from lagrangian_ff.identification.solving.fit import Fit
from lagrangian_ff.identification.solving.landmark_equations import LandmarkEquations
from lagrangian_ff.identification.solving.robust import (
    ENOUGH,
    FEW_STEPS,
    ROUGH,
    STEPS,
    Solvable,
    doubted,
    huber,
)
from lagrangian_ff.identification.solving.solution import (
    STRONGER,
    NotPositiveDefiniteError,
    with_least_noise,
)
from lagrangian_ff.kernels import States
from lagrangian_ff.progress import Progress, part, silent

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Solved:
    """A fit and what came with it.

    Attributes:
        fitted: the model.
        weighed: the same model as certainty is made from it: outliers say no more than others.
        threshold: (N,) N·m, beyond which Huber's loss is linear; None for squares.
        noise: (N,) variance of few samples that it was solved with.
        notes: what had to be done, in words.
    """

    fitted: Fit
    weighed: Fit
    threshold: Floats | None
    noise: Floats
    notes: tuple[str, ...]


def solve(blueprint: Blueprint, inputs: Inputs, progress: Progress = silent) -> Solved:
    """Solve (44), where the Gram matrix has no factor with the least noise added that mends it.

    Args:
        blueprint: what the model is made from.
        inputs: all of the data as effects see it.
        progress: told the share done.

    Raises:
        ModelError: there is no factor with much more noise either.
    """
    x = inputs.take(blueprint.seen)

    def solved(factor: float) -> Solved:
        noise = blueprint.choice.noise * factor
        noisier = replace(blueprint, choice=replace(blueprint.choice, noise=noise))
        fitted, weighed, threshold = _with_loss(noisier, x, progress)
        notes = (*_raised(factor, len(blueprint.index)), *_landmarks(noisier, fitted))
        return Solved(fitted, weighed, threshold, noise, notes)

    try:
        return with_least_noise(solved)[0]
    except NotPositiveDefiniteError as error:
        raise ModelError(
            f"the Gram matrix of {len(blueprint.index)} samples has no Cholesky factor, with "
            f"{STRONGER[-1]:g} times the chosen noise neither: look for impossible velocities and "
            f"accelerations in the recording (up to {np.abs(x.qd).max():.3g} rad/s and "
            f"{np.abs(x.qdd).max():.3g} rad/s² here), or use fewer samples or --selection "
            "validation"
        ) from error


def _with_loss(
    blueprint: Blueprint, x: Inputs, progress: Progress
) -> tuple[Fit, Fit, Floats | None]:
    """`Solved.fitted`, `Solved.weighed` and `Solved.threshold`."""
    tau, trust = blueprint.data.tau[blueprint.seen], blueprint.trust
    parts = blueprint.basis, blueprint.choice, x, tau, blueprint.scaling
    equations: Solvable
    if blueprint.exact:
        equations, enough, steps = Equations.of(*parts), ENOUGH, STEPS
    else:
        at = blueprint.data.take(blueprint.index)
        landmarks = States.of(at.q, at.qd, at.qdd)
        equations = LandmarkEquations.of(*parts, landmarks, blueprint.folded)
        enough, steps = ROUGH, FEW_STEPS
    if trust is None:
        fitted = equations.solve(progress=progress)
        return fitted, fitted, None
    robust = huber(equations, trust, None, enough, steps, part(progress, 0.0, 0.9))
    weighed = equations.solve(doubted(robust.fitted.trust), progress=part(progress, 0.9, 1.0))
    return robust.fitted, weighed, robust.threshold


def _raised(factor: float, samples: int) -> tuple[str, ...]:
    if factor == 1.0:
        return ()
    return (
        f"the noise is taken {factor:g} times as large as was chosen: with less, the Gram matrix "
        f"of {samples} samples has no Cholesky factor",
    )


def _landmarks(blueprint: Blueprint, fitted: Fit) -> tuple[str, ...]:
    if blueprint.exact:
        return ()
    raised = np.unique(np.round(fitted.choice.noise / blueprint.choice.noise)).astype(int)
    rate = 1.0 / float(np.median(np.diff(blueprint.data.time)))
    shown = " to ".join(str(factor) for factor in dict.fromkeys([raised.min(), raised.max()]))
    return (
        f"learned from all {len(blueprint.seen)} training samples at {rate:.3g} Hz, with a "
        f"kernel on {len(blueprint.index)} of them as landmarks; blocks left out ask for {shown} "
        "times the noise variance of few samples, since neighbouring samples err alike",
    )
