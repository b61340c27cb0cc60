"""Choosing a kernel and its hyperparameters, in the way that suits the kernel.

The paper's kernels have a few numbers, which a simplex search finds (see `search`). Structured
kernels have several a joint: their evidence is climbed (see `evidence`), and what blocks left out
say decides between several kernels and scalings, and how much more noise than the evidence thinks
the errors of a real arm, which are no white noise, ask for.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from lagrangian_ff.identification.evidence import climb
from lagrangian_ff.identification.fit import Choice, Scaling, fit
from lagrangian_ff.identification.search import (
    choose,
    require_folds,
    starting_choice,
    validation_score,
)
from lagrangian_ff.identification.spec import Spec
from lagrangian_ff.identification.system import NotPositiveDefiniteError
from lagrangian_ff.identification.training import TrainingSet
from lagrangian_ff.kernels import DifferentiableKernel
from lagrangian_ff.progress import Progress, part, silent

STAGES = ((120, 30), (240, 12))
"""Samples the evidence is climbed with, and steps at most."""
NOISE_FACTORS = (1.0, 3.0, 10.0, 30.0, 100.0)
JUDGED_SAMPLES = 240


@dataclass(frozen=True)
class Chosen:
    """What was found best.

    Attributes:
        spec: with one kernel.  choice: its numbers.  scaling: of the torques.
        tried: for each kernel and scaling tried, what blocks left out, or the evidence, say of it.
    """

    spec: Spec
    choice: Choice
    scaling: Scaling
    tried: tuple[dict[str, object], ...] = ()


def choose_all(
    spec: Spec,
    data: TrainingSet,
    scalings: Sequence[Scaling],
    criterion: str = "validation",
    evaluations: int = 90,
    progress: Progress = silent,
) -> Chosen:
    """Choose everything about a model that is not linear in the torques; see `search.choose`.

    Raises:
        ModelError: the criterion is unknown, or there is one fold only to validate on.
        NotPositiveDefiniteError: no start has a factor.
    """
    if not issubclass(spec.kernel, DifferentiableKernel):
        return Chosen(spec, *choose(spec, data, scalings, criterion, evaluations, progress))
    require_folds(data, criterion)
    ways = [(one, scaling) for one in spec.alternatives for scaling in scalings]
    found: list[tuple[float, Chosen]] = []
    tried: list[dict[str, object]] = []
    for number, (one, scaling) in enumerate(ways):
        share = part(progress, number / len(ways), (number + 1) / len(ways))
        start = starting_choice(one, data.states)
        choice, evidence = climb(one, start, data, scaling, STAGES, share)
        cost = -evidence
        if criterion == "validation":
            choice, cost = _least_error(one, choice, data, scaling)
        found.append((cost, Chosen(one, choice, scaling)))
        common = "common" if np.ptp(scaling.unit) == 0.0 else "joint"
        tried.append(
            {"kernel": one.kernel.name, "scale": common, "evidence": evidence, criterion: cost}
        )
    best = min(found, key=lambda item: item[0])[1]
    return replace(best, tried=tuple(tried))


def _least_error(
    spec: Spec, choice: Choice, data: TrainingSet, scaling: Scaling
) -> tuple[Choice, float]:
    """The choice with the noise that leaves the smallest error on blocks left out, and it."""
    thinned = data.thinned(JUDGED_SAMPLES)
    groups = thinned.groups()
    best, least = choice, np.inf
    for factor in NOISE_FACTORS:
        tried = replace(choice, noise=choice.noise * factor)
        try:
            fitted = fit(spec, tried, thinned.x, thinned.tau, scaling)
            score = float(np.nanmean(validation_score(fitted, groups)))
        except (NotPositiveDefiniteError, np.linalg.LinAlgError):
            continue
        if score < least:
            best, least = tried, score
    return best, least
