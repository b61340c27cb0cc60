"""Choosing a kernel and its hyperparameters, in the way that suits the kernel.

The paper's kernels have a few numbers, which a simplex search finds (see `search`). Structured
kernels have several a joint: their evidence is climbed (see `evidence`), and what blocks left out
say decides between several kernels and scalings, and how much more noise than the evidence thinks
the errors of a real arm, which are no white noise, ask for. All that is done on some samples; how
steeply friction turns round, which only the slow ones show, is then looked at on all.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from lagrangian_ff.errors import ModelError
from lagrangian_ff.identification.choice import Choice, Scaling
from lagrangian_ff.identification.choosing.evidence import climb
from lagrangian_ff.identification.choosing.search import (
    choose,
    require_folds,
    starting_choice,
    validation_score,
)
from lagrangian_ff.identification.choosing.shapes import tuned
from lagrangian_ff.identification.choosing.training import TrainingSet
from lagrangian_ff.identification.solving.equations import fit
from lagrangian_ff.identification.solving.solution import NotPositiveDefiniteError
from lagrangian_ff.identification.spec import Spec
from lagrangian_ff.kernels import DifferentiableKernel
from lagrangian_ff.progress import Progress, part, silent

FIRST, LAST = ((60, 30), (120, 12)), ((240, 12),)
"""Samples the evidence is climbed with, and steps at most: on every way, and on the best."""
EVALUATIONS = 90
"""What the steps are meant for."""
NOISE_FACTORS = (1.0, 3.0, 10.0, 30.0, 100.0)
JUDGED_SAMPLES = 240
SHAPED_TORQUES = 4000
"""As many as the shapes of friction are chosen on, at most."""


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
        ModelError: there is one fold only to validate on, or no start has a factor.
    """
    if not issubclass(spec.kernel, DifferentiableKernel):
        return Chosen(spec, *choose(spec, data, scalings, criterion, evaluations, progress))
    require_folds(data)
    first, last = (_for(stages, evaluations) for stages in (FIRST, LAST))
    ways = [_Way.started(one, scaling, data) for one in spec.alternatives for scaling in scalings]
    whole = len(ways) * _work(first) + _work(last)
    judged = []
    for number, way in enumerate(ways):
        told = part(progress, number * _work(first) / whole, (number + 1) * _work(first) / whole)
        try:
            judged.append(way.climbed(data, first, criterion, told))
        except NotPositiveDefiniteError:
            continue
    if not judged:
        raise ModelError(
            f"the Gram matrix of {spec.text} has no Cholesky factor on this motion, however much "
            "noise is assumed: look for impossible velocities and accelerations in the recording "
            f"(up to {np.abs(data.x.qd).max():.3g} rad/s and {np.abs(data.x.qdd).max():.3g} rad/s² "
            "here)"
        )
    best = min(judged, key=lambda way: way.cost)
    higher = best.climbed(data, last, criterion, part(progress, 1.0 - _work(last) / whole, 1.0))
    tried = tuple(way.record(criterion) for way in (*judged, higher))
    # Samples that lie close share their errors, in which the evidence then sees dynamics.
    if criterion == "evidence" or higher.cost < best.cost:
        best = higher
    shown = data.thinned(SHAPED_TORQUES // data.states.joints)
    choice = _reshaped(best.spec, best.judged, shown, best.scaling)
    return Chosen(best.spec, choice, best.scaling, tried)


Stages = Sequence[tuple[int, int]]


def _for(stages: Stages, evaluations: int) -> Stages:
    """The stages with steps in proportion to the usual number of evaluations."""
    return [
        (samples, max(1, round(steps * evaluations / EVALUATIONS))) for samples, steps in stages
    ]


def _work(stages: Stages) -> float:
    """What stages cost, about: pairs of samples, steps times."""
    return float(sum(steps * samples**2 for samples, steps in stages))


@dataclass(frozen=True)
class _Way:
    """A kernel and a scaling of the torques, and how far they have come.

    Attributes:
        start: before the climb.  top: where it stands.  judged: with the noise that suits best.
        samples: it has climbed with.  evidence: there.  cost: what is made small.
    """

    spec: Spec
    scaling: Scaling
    start: Choice
    top: Choice
    judged: Choice
    samples: int = 0
    evidence: float = -np.inf
    cost: float = np.inf

    @classmethod
    def started(cls, spec: Spec, scaling: Scaling, data: TrainingSet) -> "_Way":
        start = starting_choice(spec, data.states)
        return cls(spec, scaling, start, start, start)

    def climbed(
        self, data: TrainingSet, stages: Stages, criterion: str, progress: Progress
    ) -> "_Way":
        """Farther up, and judged there."""
        top, evidence = climb(
            self.spec, self.start, data, self.scaling, stages, progress, first=self.top
        )
        judged, cost = top, -evidence
        if criterion == "validation":
            judged, cost = _least_error(self.spec, top, data, self.scaling)
        samples = stages[-1][0]
        return replace(self, top=top, judged=judged, samples=samples, evidence=evidence, cost=cost)

    def record(self, criterion: str) -> dict[str, object]:
        """What it was, and what is said of it."""
        return {
            "kernel": self.spec.kernel.name,
            "scale": "common" if np.ptp(self.scaling.unit) == 0.0 else "joint",
            "samples": self.samples,
            "evidence": self.evidence,
            criterion: self.cost,
        }


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
            fitted = fit(spec, tried, thinned.x, thinned.tau, scaling, thinned.trust)
            score = float(np.nanmean(validation_score(fitted, groups)))
        except (NotPositiveDefiniteError, np.linalg.LinAlgError):
            continue
        if score < least:
            best, least = tried, score
    return best, least


def _reshaped(spec: Spec, choice: Choice, data: TrainingSet, scaling: Scaling) -> Choice:
    """The choice with friction's shapes where least of all these samples is left."""
    if not choice.shapes:
        return choice
    try:
        fitted = fit(spec, choice, data.x, data.tau, scaling, data.trust)
    except NotPositiveDefiniteError:  # more noise may be added when the model is made
        return choice
    basis = fitted.basis
    for joint in range(data.states.joints):
        basis = tuned(fitted, basis, joint, data.x)
    return choice.shaped_as(basis)
