"""Choosing a kernel and its hyperparameters where some torques are grossly wrong."""

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from lagrangian_ff.effects import Inputs
from lagrangian_ff.errors import ModelError
from lagrangian_ff.identification.choice import Scaling
from lagrangian_ff.identification.choosing.choose import Chosen, choose_all
from lagrangian_ff.identification.choosing.search import starting_choice
from lagrangian_ff.identification.choosing.training import TrainingSet
from lagrangian_ff.identification.model import CHUNK_SAMPLES
from lagrangian_ff.identification.solving.equations import Equations
from lagrangian_ff.identification.solving.fit import Fit
from lagrangian_ff.identification.solving.robust import (
    ROUGH,
    at_sight,
    doubted,
    huber,
    threshold_of,
    trust_in,
)
from lagrangian_ff.identification.solving.solution import (
    STRONGER,
    NotPositiveDefiniteError,
    with_least_noise,
)
from lagrangian_ff.identification.spec import Spec
from lagrangian_ff.progress import Progress, part, silent

Floats = NDArray[np.float64]

QUICK_SAMPLES = 120
"""Samples on which a robust choice finds out roughly what to trust, twice: before anything is
chosen, a model is too poor to tell."""


def choose_robustly(
    spec: Spec,
    data: TrainingSet,
    scalings: Callable[[Floats, Floats], Sequence[Scaling]],
    criterion: str = "validation",
    evaluations: int = 90,
    progress: Progress = silent,
) -> tuple[Chosen, Floats]:
    """Choose as `choose_all` does, undisturbed by gross errors of torque.

    What is trusted follows from a fit with Huber's loss, and the choice from what is trusted; so
    both are found on few samples first. While numbers are tried, trust stays as it is.

    Args:
        scalings: the ways to normalise torques (M, N) that are tried, for the trust (M, N) in them.

    Returns:
        The choice, and the trust (M, N) that goes with it.

    Raises:
        ModelError: see `choose_all`; or there is no factor with much more noise either.
    """
    scaling = scalings(data.tau, doubted(at_sight(data.tau)))[0]
    chosen = Chosen(spec.alternatives[0], starting_choice(spec, data.states), scaling)
    few = data.thinned(QUICK_SAMPLES)
    for some, low, high in ((few, 0.0, 0.15), (few, 0.15, 0.3), (data, 0.3, 1.0)):
        trust = doubted(_trust(chosen, some))
        known, ways = replace(some, trust=trust), scalings(some.tau, trust)
        told = part(progress, low, high)
        chosen = choose_all(spec, known, ways, criterion, evaluations, told)
    chosen = replace(chosen, fitted=None)  # it is of squares
    return chosen, _trust(chosen, data)


def trust_beyond(
    chosen: Chosen, data: TrainingSet, trust: Floats, x: Inputs, tau: Floats
) -> Floats:
    """(S, N) in many torques, by how far they are from a fit to few of them.

    Args:
        chosen: hyperparameters.
        data: the M few.  trust: (M, N) in them.
        x: S samples.  tau: (S, N) N·m.

    Raises:
        ModelError: there is no factor with much more noise either.
    """
    fitted = _solved(chosen, data, lambda equations: equations.solve(doubted(trust)))
    chunks = np.split(np.arange(len(x)), range(CHUNK_SAMPLES, len(x), CHUNK_SAMPLES))
    residual = tau - np.concatenate([fitted.torque(x.take(chunk)) for chunk in chunks])
    return trust_in(residual, threshold_of(residual, chosen.scaling.spread))


def _trust(chosen: Chosen, data: TrainingSet) -> Floats:
    """(M, N) by how far each torque is from a robust fit that did not see its block.

    A fit to the torques themselves follows most of them as closely as its noise is small, so that
    all that is not easy would look like an outlier, and the noise chosen next be smaller still.
    """
    fitted = _solved(chosen, data, lambda equations: huber(equations, enough=ROUGH).fitted)
    groups = data.groups()
    residual = fitted.left_out(groups)[0] if len(groups) > 1 else fitted.residual
    return trust_in(residual, threshold_of(residual, chosen.scaling.spread))


def _solved(chosen: Chosen, data: TrainingSet, how: Callable[[Equations], Fit]) -> Fit:
    """A fit; noise that few samples bear may be too little for these."""
    basis = chosen.choice.basis(chosen.spec, data.x.joints)

    def solved(factor: float) -> Fit:
        choice = replace(chosen.choice, noise=chosen.choice.noise * factor)
        return how(Equations.of(basis, choice, data.x, data.tau, chosen.scaling))

    try:
        return with_least_noise(solved)[0]
    except NotPositiveDefiniteError as error:
        raise ModelError(
            f"the Gram matrix of {len(data.x)} samples has no Cholesky factor, with "
            f"{STRONGER[-1]:g} times the chosen noise neither: look for impossible velocities and "
            "accelerations in the recording"
        ) from error
