"""From a blueprint to a fit: exactly, or on landmarks."""

import numpy as np

from lagrangian_ff.effects import Inputs
from lagrangian_ff.errors import ModelError
from lagrangian_ff.identification.blueprint import Blueprint
from lagrangian_ff.identification.fit import Fit, fit_basis
from lagrangian_ff.identification.fit_landmarks import fit_landmarks
from lagrangian_ff.identification.system import NotPositiveDefiniteError
from lagrangian_ff.kernels import States
from lagrangian_ff.progress import Progress, silent


def solve(blueprint: Blueprint, inputs: Inputs, progress: Progress = silent) -> Fit:
    """Solve (44).

    Args:
        blueprint: what the model is made from.
        inputs: all of the data as effects see it.
        progress: told the share done.

    Raises:
        ModelError: the chosen noise is too small for the arithmetic, or the landmarks take too
            much memory.
    """
    x, tau = inputs.take(blueprint.seen), blueprint.data.tau[blueprint.seen]
    parts = blueprint.basis, blueprint.choice, x, tau, blueprint.scaling
    if not blueprint.exact:
        at = blueprint.data.take(blueprint.index)
        landmarks = States.of(at.q, at.qd, at.qdd)
        return fit_landmarks(*parts, landmarks, blueprint.folded, progress)
    try:
        return fit_basis(*parts)
    except NotPositiveDefiniteError as error:
        raise ModelError(
            f"the Gram matrix of {len(x)} samples has no Cholesky factor ({error}): "
            "the chosen noise is too small for it; use fewer samples or --selection validation"
        ) from error


def notes_of(blueprint: Blueprint, fitted: Fit) -> list[str]:
    """What is to be said of how it was solved."""
    if blueprint.exact:
        return []
    raised = np.unique(np.round(fitted.choice.noise / blueprint.choice.noise)).astype(int)
    rate = 1.0 / float(np.median(np.diff(blueprint.data.time)))
    shown = " to ".join(str(factor) for factor in dict.fromkeys([raised.min(), raised.max()]))
    return [
        f"learned from all {len(blueprint.seen)} training samples at {rate:.3g} Hz, with a "
        f"kernel on {len(blueprint.index)} of them as landmarks; blocks left out ask for {shown} "
        "times the noise variance of few samples, since neighbouring samples err alike"
    ]
