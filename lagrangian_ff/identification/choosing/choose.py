"""Choosing a kernel and its hyperparameters, in the way that suits the kernel.

The paper's kernels have a few numbers, which a simplex search finds (see `search`). Structured
kernels have several a joint: their evidence is climbed (see `evidence`), and what blocks left out
say decides between several kernels and scalings, and how much more noise than the evidence thinks
the errors of a real arm, which are no white noise, ask for. All that is done on some samples; how
steeply friction turns round, which only the slow ones show, is then looked at on all.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from threadpoolctl import threadpool_limits

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
from lagrangian_ff.identification.solving.equations import fit, rebased
from lagrangian_ff.identification.solving.fit import Fit
from lagrangian_ff.identification.solving.solution import NotPositiveDefiniteError
from lagrangian_ff.identification.solving.system import System
from lagrangian_ff.identification.spec import Spec
from lagrangian_ff.kernels import DifferentiableKernel
from lagrangian_ff.progress import Progress, part, silent

FIRST, SECOND, LAST = (60, 30), (120, 12), (240, 4)
"""Samples the evidence is climbed with, and steps at most: on every way, on those that are not
clearly worse than the best, and on the best."""
WORSE = 1.5
"""Times the least error of the ways on blocks left out: one with more is clearly worse."""
EVALUATIONS = 90
"""What the steps are meant for."""
NOISE_FACTORS = (1.0, 3.0, 10.0, 30.0, 100.0)
ROUGH_SAMPLES, JUDGED_SAMPLES = 120, 240
SHAPED_TORQUES = 4000
"""As many as the shapes of friction are chosen on, at most, where the fit is of no further use."""


@dataclass(frozen=True)
class Chosen:
    """What was found best.

    Attributes:
        spec: with one kernel.  choice: its numbers.  scaling: of the torques.
        tried: for each kernel and scaling tried, what blocks left out, or the evidence, say of it.
        fitted: the model, solved with all of these samples; None where it was not.
    """

    spec: Spec
    choice: Choice
    scaling: Scaling
    tried: tuple[dict[str, object], ...] = ()
    fitted: Fit[System] | None = field(default=None, repr=False)


def choose_all(
    spec: Spec,
    data: TrainingSet,
    scalings: Sequence[Scaling],
    criterion: str = "validation",
    evaluations: int = 90,
    progress: Progress = silent,
    shaped: int = SHAPED_TORQUES,
) -> Chosen:
    """Choose everything about a model that is not linear in the torques; see `search.choose`.

    Args:
        spec, data, scalings, criterion, evaluations, progress: see there.
        shaped: torques that the shapes of friction are chosen on, at most.

    Raises:
        ModelError: there is one fold only to validate on, or no start has a factor.
    """
    if not issubclass(spec.kernel, DifferentiableKernel):
        return Chosen(spec, *choose(spec, data, scalings, criterion, evaluations, progress))
    require_folds(data)
    first, second, last = (_for(stage, evaluations) for stage in (FIRST, SECOND, LAST))
    ways = len(spec.alternatives) * len(scalings)
    whole = ways * (_work(first) + _work(second)) + _work(last)
    few, more = data.thinned(ROUGH_SAMPLES), data.thinned(JUDGED_SAMPLES)
    tried: list[_Way] = []
    done = 0.0

    def higher(way: _Way, stage: Stage, judges: TrainingSet) -> _Way | None:
        nonlocal done
        told = part(progress, done / whole, (done + _work(stage)) / whole)
        done += _work(stage)
        try:
            tried.append(way.climbed(data, stage, told).judged(judges, criterion))
        except NotPositiveDefiniteError:
            return None
        return tried[-1]

    hopeful: list[_Way] = []
    for kernel in spec.alternatives:
        # A scaling that is clearly worse with one kernel is so with the next.
        left = [one for one in scalings if any(way.scaling is one for way in hopeful)]
        starts = [_Way.started(kernel, scaling, data) for scaling in left or scalings]
        hopeful += [way for one in starts if (way := higher(one, first, few))]
        hopeful = _hopeful(hopeful, criterion)
    if not hopeful:
        raise ModelError(
            f"the Gram matrix of {spec.text} has no Cholesky factor on this motion, however much "
            "noise is assumed: look for impossible velocities and accelerations in the recording "
            f"(up to {np.abs(data.x.qd).max():.3g} rad/s and {np.abs(data.x.qdd).max():.3g} rad/s² "
            "here)"
        )
    pairs = [(higher(way, second, few) or way, way) for way in hopeful]
    best, before = min(pairs, key=lambda pair: pair[0].cost)
    misled = criterion == "validation" and best.cost > before.cost
    best = best.judged(more, criterion)
    # Samples that lie close share their errors, in which the evidence then sees dynamics.
    if not misled:
        done = whole - _work(last)
        top = higher(best, last, more)
        if top and (criterion == "evidence" or top.cost < best.cost):
            best = top
    shown = data.thinned(shaped // data.states.joints)
    records = tuple(way.record(criterion) for way in tried)
    chosen = Chosen(best.spec, best.choice, best.scaling, records)
    progress(1.0, "fitting")
    reshaped = _reshaped(chosen, shown)
    return reshaped if len(shown.x) == len(data.x) else replace(reshaped, fitted=None)


Stage = tuple[int, int]


def _for(stage: Stage, evaluations: int) -> Stage:
    """The stage with steps in proportion to the usual number of evaluations."""
    samples, steps = stage
    return samples, max(1, round(steps * evaluations / EVALUATIONS))


def _work(stage: Stage) -> float:
    """What a stage costs, about: pairs of samples, steps times."""
    samples, steps = stage
    return float(steps * samples**2)


@dataclass(frozen=True)
class _Way:
    """A kernel and a scaling of the torques, and how far they have come.

    Attributes:
        start: before the climb.  top: where it stands.  choice: with the noise that suits best.
        factor: which of `NOISE_FACTORS` that is.
        samples: it has climbed with.  evidence: there.  cost: what is made small.
    """

    spec: Spec
    scaling: Scaling
    start: Choice
    top: Choice
    choice: Choice
    factor: int = 0
    samples: int = 0
    evidence: float = -np.inf
    cost: float = np.inf

    @classmethod
    def started(cls, spec: Spec, scaling: Scaling, data: TrainingSet) -> "_Way":
        start = starting_choice(spec, data.states)
        return cls(spec, scaling, start, start, start)

    def climbed(self, data: TrainingSet, stage: Stage, progress: Progress) -> "_Way":
        """Farther up."""
        top, evidence = climb(
            self.spec, self.start, data, self.scaling, [stage], progress, first=self.top
        )
        return replace(self, top=top, samples=stage[0], evidence=evidence)

    def judged(self, data: TrainingSet, criterion: str) -> "_Way":
        """With what is to be said of where it stands."""
        if criterion == "evidence":
            return replace(self, choice=self.top, cost=-self.evidence)
        # Threads cost more than they bring on matrices as small as these.
        with threadpool_limits(1):
            factor, choice, cost = _least_error(
                self.spec, self.top, data, self.scaling, self.factor
            )
        return replace(self, factor=factor, choice=choice, cost=cost)

    def record(self, criterion: str) -> dict[str, object]:
        """What it was, and what is said of it."""
        return {
            "kernel": self.spec.kernel.name,
            "scale": "common" if np.ptp(self.scaling.unit) == 0.0 else "joint",
            "samples": self.samples,
            "evidence": self.evidence,
            criterion: self.cost,
        }


def _hopeful(ways: Sequence[_Way], criterion: str) -> list[_Way]:
    """Those that blocks left out do not speak clearly against."""
    if criterion == "evidence":
        return list(ways)
    least = min((way.cost for way in ways), default=0.0)
    return [way for way in ways if way.cost <= WORSE * least]


def _least_error(
    spec: Spec, choice: Choice, data: TrainingSet, scaling: Scaling, first: int
) -> tuple[int, Choice, float]:
    """Which of `NOISE_FACTORS` leaves the smallest error on blocks left out, the choice, the error.

    From the first that is tried to its neighbours, as long as the error falls.
    """
    groups = data.groups()
    met: dict[int, float] = {}

    def noisier(factor: int) -> Choice:
        return replace(choice, noise=choice.noise * NOISE_FACTORS[factor])

    def error(factor: int) -> float:
        if factor not in met:
            try:
                fitted = fit(spec, noisier(factor), data.x, data.tau, scaling, data.trust)
                met[factor] = float(np.nanmean(validation_score(fitted, groups)))
            except (NotPositiveDefiniteError, np.linalg.LinAlgError):
                met[factor] = np.inf
        return met[factor]

    best = first
    for step in (1, -1):
        while best + step in range(len(NOISE_FACTORS)) and (
            error(best + step) < error(best) or not np.isfinite(error(best))
        ):
            best += step
    return best, noisier(best), error(best)


def _reshaped(chosen: Chosen, data: TrainingSet) -> Chosen:
    """The same with friction's shapes where least of all these samples is left."""
    choice = chosen.choice
    try:
        fitted = fit(chosen.spec, choice, data.x, data.tau, chosen.scaling, data.trust)
    except NotPositiveDefiniteError:  # more noise may be added when the model is made
        return chosen
    basis = fitted.basis
    for joint in range(data.states.joints):
        basis = tuned(fitted, basis, joint, data.x)
    fitted = rebased(fitted, basis, data.x, data.tau)
    return replace(chosen, choice=fitted.choice, fitted=fitted)
