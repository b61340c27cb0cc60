"""Choosing a kernel and its hyperparameters, in the way that suits the kernel.

The paper's kernels have a few numbers, which a simplex search finds (see `search`). Structured
kernels have several a joint: their evidence is maximised (see `evidence`), and blocks left out
decide between kernels and scalings, and by how much the noise is raised, since the errors of a real
arm are not white. All that uses a subset of the samples; the width of the Coulomb step, which only
slow samples show, is then chosen on all.

With Huber's loss the IRLS weights follow from a fit, and the choice from the weights.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from threadpoolctl import threadpool_limits

from lagrangian_ff.arrays import Floats
from lagrangian_ff.effects import Inputs
from lagrangian_ff.identification.choosing.evidence import (
    FAR,
    NEAR,
    Logarithms,
    maximise_evidence,
    solvable,
)
from lagrangian_ff.identification.choosing.shapes import refit_shapes
from lagrangian_ff.identification.choosing.simplex import require_folds, search, validation_score
from lagrangian_ff.identification.predicting import CHUNK_SAMPLES
from lagrangian_ff.identification.problem import Problem, Scaling
from lagrangian_ff.identification.records import Tried
from lagrangian_ff.identification.samples import Samples
from lagrangian_ff.identification.settings import Settings
from lagrangian_ff.identification.solving.posterior import Posterior, exact, exact_solver, rebased
from lagrangian_ff.identification.solving.robust import (
    ROUGH,
    at_sight,
    heavy_tailed,
    huber,
    threshold_of,
    weights_of,
)
from lagrangian_ff.identification.solving.solution import (
    NotPositiveDefiniteError,
    no_factor,
    with_least_noise,
)
from lagrangian_ff.identification.solving.system import System
from lagrangian_ff.identification.spec import Spec
from lagrangian_ff.progress import Progress, part, silent

QUICK_SAMPLES = 120
"""Samples on which a robust choice finds rough weights, twice: the first model is too poor."""
FIRST, SECOND, LAST = (60, 30), (120, 12), (240, 4)
"""Samples that the evidence is maximised on, and steps at most: for every candidate, for those that
are not clearly worse than the best, and for the best."""
WORSE = 1.5
"""Multiple of the least error on blocks left out beyond which a candidate is clearly worse."""
NOISE_FACTORS = (1.0, 3.0, 10.0, 30.0, 100.0)
ROUGH_SAMPLES, JUDGED_SAMPLES = 120, 240
ENOUGH = 0.5
"""Nats that a step must bring for another to be tried; less hardly changes the error."""
SHAPED_TORQUES = 4000
"""Torques that the shapes of friction are chosen on, at most, if the fit is not the model's."""


@dataclass(frozen=True)
class Chosen:
    """The best candidate.

    Attributes:
        spec: with one kernel.
        problem: of the samples it was chosen on, with the hyperparameters.
        tried: each kernel and scaling tried, with its error or evidence.
        posterior: of the problem; None if it was not solved.
    """

    spec: Spec
    problem: Problem
    tried: tuple[Tried, ...] = ()
    posterior: Posterior[System] | None = field(default=None, repr=False)


def choose(
    spec: Spec,
    samples: Samples,
    scalings: Sequence[Scaling],
    settings: Settings,
    progress: Progress = silent,
    shaped: int = SHAPED_TORQUES,
) -> Chosen:
    """Choose kernel, scaling, hyperparameters, noise and shapes of friction.

    Args:
        spec, samples, scalings, settings, progress: see `simplex.search`.
        shaped: see `SHAPED_TORQUES`.

    Raises:
        ModelError: there is one fold only to validate on, or no candidate can be solved.
    """
    if not spec.kernel.differentiable:
        return Chosen(spec, search(spec, samples, scalings, settings, progress))
    require_folds(samples)
    criterion = settings.selection
    first, second, last = (_for(stage, settings) for stage in (FIRST, SECOND, LAST))
    count = len(spec.alternatives) * len(scalings)
    whole = count * (_work(first) + _work(second)) + _work(last)
    rough, fine = samples.thinned(ROUGH_SAMPLES), samples.thinned(JUDGED_SAMPLES)
    tried: list[_Candidate] = []
    done = 0.0

    def improved(one: _Candidate, stage: Stage, judges: Samples) -> _Candidate | None:
        nonlocal done
        share = part(progress, done / whole, (done + _work(stage)) / whole)
        done += _work(stage)
        try:
            tried.append(one.improved(samples, stage, share).judged(judges, criterion))
        except NotPositiveDefiniteError:
            return None
        return tried[-1]

    kept: list[_Candidate] = []
    for kernel in spec.alternatives:
        # A scaling that is clearly worse with one kernel is so with the next.
        used = [one.latest.prior.scaling for one in kept]
        left = [scaling for scaling in scalings if any(one is scaling for one in used)]
        starts = [Problem.started(kernel, samples, scaling) for scaling in left or scalings]
        candidates = [_Candidate(kernel, start, start, start) for start in starts]
        kept += [one for candidate in candidates if (one := improved(candidate, first, rough))]
        if criterion == "validation":
            least = min((one.cost for one in kept), default=0.0)
            kept = [one for one in kept if one.cost <= WORSE * least]
    if not kept:
        raise no_factor(spec.text, samples.x.qd, samples.x.qdd)
    pairs = [(improved(one, second, rough) or one, one) for one in kept]
    best, before = min(pairs, key=lambda pair: pair[0].cost)
    misled = criterion == "validation" and best.cost > before.cost
    best = best.judged(fine, criterion)
    # Samples that lie close share their errors, which the evidence then takes for dynamics.
    if not misled:
        done = whole - _work(last)
        final = improved(best, last, fine)
        if final and (criterion == "evidence" or final.cost < best.cost):
            best = final
    shown = samples.thinned(shaped // samples.x.joints)
    chosen = Chosen(best.spec, best.choice.of(shown), tuple(one.shown(criterion) for one in tried))
    progress(1.0, "fitting")
    chosen = _reshaped(chosen)
    if len(shown) == len(samples):
        return chosen
    return replace(chosen, problem=chosen.problem.of(samples), posterior=None)


Stage = tuple[int, int]


def _for(stage: Stage, settings: Settings) -> Stage:
    """Return the stage with steps in proportion to the usual number of evaluations."""
    samples, steps = stage
    return samples, max(1, round(steps * settings.evaluations / Settings.evaluations))


def _work(stage: Stage) -> float:
    """Return the approximate cost of a stage: steps times pairs of samples."""
    samples, steps = stage
    return float(steps * samples**2)


@dataclass(frozen=True)
class _Candidate:
    """A kernel and a scaling of the torques, with the hyperparameters found so far.

    Attributes:
        start: before any step.  latest: after the last.  choice: with the best noise.
        factor: index of that noise in `NOISE_FACTORS`.
        samples: number in the last steps.  evidence: on these.  cost: to minimise.
    """

    spec: Spec
    start: Problem
    latest: Problem
    choice: Problem
    factor: int = 0
    samples: int = 0
    evidence: float = -np.inf
    cost: float = np.inf

    def improved(self, samples: Samples, stage: Stage, progress: Progress) -> "_Candidate":
        """Return the candidate after some more steps."""
        count, steps = stage
        logarithms = Logarithms(self.start)
        prior = logarithms.prior
        damping = FAR if np.array_equal(logarithms.of(self.latest), prior.middle) else NEAR
        begin = solvable(self.latest.of(samples.thinned(count)))
        found = maximise_evidence(begin, steps, prior, progress, enough=ENOUGH, damping=damping)
        return replace(self, latest=found.problem, samples=count, evidence=found.log_evidence)

    def judged(self, samples: Samples, criterion: str) -> "_Candidate":
        """Return the candidate with its cost."""
        if criterion == "evidence":
            return replace(self, choice=self.latest, cost=-self.evidence)
        # Threads cost more than they bring on matrices as small as these.
        with threadpool_limits(1):
            factor, choice, cost = _least_error(self.latest.of(samples), self.factor)
        return replace(self, factor=factor, choice=choice, cost=cost)

    def shown(self, criterion: str) -> Tried:
        """Return kernel, scaling, samples, evidence and cost for the findings."""
        scale = "common" if np.ptp(self.latest.unit) == 0.0 else "joint"
        costs = {"evidence": self.evidence, criterion: self.cost}
        return Tried(self.spec.kernel.name, scale, self.samples, **costs)


def _least_error(problem: Problem, first: int) -> tuple[int, Problem, float]:
    """Return index, problem and error of the best noise factor on blocks left out.

    The search goes from the first factor to its neighbours, as long as the error falls.
    """
    groups = problem.samples.groups()
    errors: dict[int, float] = {}

    def error(factor: int) -> float:
        if factor not in errors:
            try:
                found = exact(problem.noisier(NOISE_FACTORS[factor]))
                errors[factor] = float(np.nanmean(validation_score(found, groups)))
            except (NotPositiveDefiniteError, np.linalg.LinAlgError):
                errors[factor] = np.inf
        return errors[factor]

    best = first
    for step in (1, -1):
        while best + step in range(len(NOISE_FACTORS)) and (
            error(best + step) < error(best) or not np.isfinite(error(best))
        ):
            best += step
    return best, problem.noisier(NOISE_FACTORS[best]), error(best)


def _reshaped(chosen: Chosen) -> Chosen:
    """Return the choice with friction shaped to leave the least residual on all its samples."""
    try:
        found = exact(chosen.problem)
    except NotPositiveDefiniteError:  # more noise may be added when the model is made
        return chosen
    basis = found.problem.basis
    for joint in range(chosen.problem.samples.x.joints):
        basis = refit_shapes(found, basis, joint)
    found = rebased(found, basis)
    return replace(chosen, problem=found.problem, posterior=found)


def choose_robustly(
    spec: Spec,
    samples: Samples,
    scalings: Callable[[Floats, Floats], Sequence[Scaling]],
    settings: Settings,
    progress: Progress = silent,
) -> tuple[Chosen, Floats]:
    """Choose as `choose` does, undisturbed by gross errors of torque.

    The weights follow from a fit with Huber's loss, and the choice from the weights; so both are
    found on a subset of the samples first. During a choice the weights stay as they are.

    Args:
        spec, samples, settings, progress: see `choose`.
        scalings: returns the scalings to try for torques (S, N) and their weights (S, N).

    Returns:
        The choice, and the IRLS weights (S, N) that go with it.

    Raises:
        ModelError: see `choose`; or there is no Cholesky factor even with much more noise.
    """
    scaling = scalings(samples.tau, heavy_tailed(at_sight(samples.tau)))[0]
    chosen = Chosen(spec, Problem.started(spec.alternatives[0], samples, scaling))
    subset = samples.thinned(QUICK_SAMPLES)
    for some, low, high in ((subset, 0.0, 0.15), (subset, 0.15, 0.3), (samples, 0.3, 1.0)):
        weight = heavy_tailed(_weights(chosen.problem.of(some)))
        known, tried = replace(some, weight=weight), scalings(some.tau, weight)
        share = part(progress, low, high)
        chosen = choose(spec, known, tried, settings, share)
    problem = chosen.problem.of(samples)
    chosen = replace(chosen, problem=problem, posterior=None)  # it has the square loss
    return chosen, _weights(problem)


def weights_beyond(problem: Problem, weight: Floats, x: Inputs, tau: Floats) -> Floats:
    """Return (S, N) IRLS weights of many torques by their distance from a fit to a subset.

    Args:
        problem: of the subset.  weight: (F, N) of its torques.
        x: S samples.  tau: (S, N) N·m.

    Raises:
        ModelError: there is no Cholesky factor even with much more noise.
    """
    found = _solved(problem.weighted(heavy_tailed(weight)), exact)
    chunks = np.split(np.arange(len(x)), range(CHUNK_SAMPLES, len(x), CHUNK_SAMPLES))
    residual = tau - np.concatenate([found.torque(x.take(chunk)) for chunk in chunks])
    return weights_of(residual, threshold_of(residual, problem.prior.scaling.spread))


def _weights(problem: Problem) -> Floats:
    """Return (S, N) IRLS weights by each torque's distance from a robust fit without its block.

    A fit with little noise follows most of the torques it was fitted to. The others would look like
    outliers, and the noise chosen next would be smaller still.
    """

    def solved(noisier: Problem) -> Posterior:
        return huber(exact_solver(noisier), enough=ROUGH).posterior

    found = _solved(problem, solved)
    groups = problem.samples.groups()
    residual = found.left_out(groups) if len(groups) > 1 else found.residual
    return weights_of(residual, threshold_of(residual, problem.prior.scaling.spread))


def _solved(problem: Problem, how: Callable[[Problem], Posterior]) -> Posterior:
    """Return the posterior, with more noise if these samples need more than a subset did."""
    try:
        return with_least_noise(lambda factor: how(problem.noisier(factor)))[0]
    except NotPositiveDefiniteError as error:
        x = problem.samples.x
        raise no_factor(f"{len(x)} samples", x.qd, x.qdd) from error
