"""Choosing a kernel and its hyperparameters, in the way that suits the kernel.

The paper's kernels have a few numbers, which a simplex search finds (see `search`). Structured
kernels have several a joint: their evidence is maximised (see `evidence`) and decides between
scalings. Blocks left out decide between kernels, and by how much the noise is raised, since the
errors of a real arm are not white. All that uses a subset of the samples; the width of the Coulomb
step, which only slow samples show, is then chosen on all.

With Huber's loss the IRLS weights follow from a fit, and the choice from the weights.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from lagrangian_ff.arrays import Floats
from lagrangian_ff.effects import Inputs
from lagrangian_ff.identification.choosing.evidence import (
    FAR,
    NEAR,
    Logarithms,
    maximise_evidence,
    solvable,
)
from lagrangian_ff.identification.choosing.gains import likeliest_gains
from lagrangian_ff.identification.choosing.left_out import (
    fold_errors,
    mean_logs,
    require_folds,
    surely_less,
    typical,
)
from lagrangian_ff.identification.choosing.shapes import refit_shapes
from lagrangian_ff.identification.choosing.simplex import search
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
from lagrangian_ff.kernels.threads import one_blas_thread
from lagrangian_ff.progress import Progress, part, silent

QUICK_SAMPLES = 120
"""Samples on which a robust choice finds rough weights, twice: the first model is too poor."""
FIRST, SECOND, LAST = (60, 30), (120, 12), (240, 4)
"""Samples that the evidence is maximised on, and steps at most: for every scaling with the first
kernel, and every other kernel with the best; for each kernel; and for the best of them."""
STRONG = 5.0
"""Nats, very strong evidence (Kass and Raftery 1995), by which a candidate that assumes less must
be the likelier one: a freer kernel, or a unit of effort for each joint."""
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
    kernels = len(spec.alternatives)
    starts_tried = kernels + len(scalings) - 1
    whole = starts_tried * _work(first) + kernels * _work(second) + _work(last)
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
        # The units of effort are those of the arm, whatever the kernel.
        left = [kept[0].latest.prior.scaling] if kept else scalings
        starts = [Problem.started(kernel, samples, scaling) for scaling in left]
        candidates = [_Candidate(kernel, start, start, start) for start in starts]
        found = [one for candidate in candidates if (one := improved(candidate, first, rough))]
        if len(found) > 1 and (gained := found[0].in_likeliest_units(samples)):
            again = improved(gained, first, rough)
            found[1:1] = [again] if again else []
        one = _likeliest(found) if found else None
        if one and not (kept and kept[0].surely_beats(one, criterion)):
            kept.append(one)
    if not kept:
        raise no_factor(spec.text, samples.x.qd, samples.x.qdd)
    pairs = [(improved(one, second, rough) or one, one) for one in kept]
    best, before = pairs[0]
    for one, earlier in pairs[1:]:
        # Where two do as well on this motion, the one that knows more physics does better beyond.
        if one.is_likelier(best) and one.surely_beats(best, criterion):
            best, before = one, earlier
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
        folds: (F,) log error on each fold left out.
    """

    spec: Spec
    start: Problem
    latest: Problem
    choice: Problem
    factor: int = 0
    samples: int = 0
    evidence: float = -np.inf
    cost: float = np.inf
    folds: Floats = field(default_factory=lambda: np.zeros(0))

    def improved(self, samples: Samples, stage: Stage, progress: Progress) -> "_Candidate":
        """Return the candidate after some more steps."""
        count, steps = stage
        logarithms = Logarithms(self.start)
        prior = logarithms.prior
        damping = FAR if np.array_equal(logarithms.of(self.latest), prior.middle) else NEAR
        begin = solvable(self.latest.of(samples.thinned(count)))
        found = maximise_evidence(begin, steps, prior, progress, enough=ENOUGH, damping=damping)
        return replace(self, latest=found.problem, samples=count, evidence=found.log_evidence)

    def in_likeliest_units(self, samples: Samples) -> "_Candidate | None":
        """Return the candidate with gains of the drives; None if the evidence is not for any."""
        latest = self.latest.of(samples.thinned(self.samples))
        gains = likeliest_gains(latest)
        # By chance, each free unit gains half a nat (Wilks 1938).
        if gains.nats <= STRONG + 0.5 * (len(gains.unit) - 1):
            return None
        latest = gains.of(latest)
        start = Problem.started(self.spec, samples, latest.prior.scaling)
        return _Candidate(self.spec, start, latest, latest)

    def judged(self, samples: Samples, criterion: str) -> "_Candidate":
        """Return the candidate with its cost."""
        if criterion == "evidence":
            return replace(self, choice=self.latest, cost=-self.evidence)
        # Threads cost more than they bring on matrices as small as these.
        with one_blas_thread():
            factor, choice, folds = _least_error(self.latest.of(samples), self.factor)
        return replace(self, factor=factor, choice=choice, cost=typical(folds), folds=folds)

    def surely_beats(self, other: "_Candidate", criterion: str) -> bool:
        """Return whether it is better by more than chance.

        Its error on folds left out must be less by a one-sided paired t-test at the 5 % level.
        """
        if criterion == "evidence" or not (len(self.folds) == len(other.folds) > 1):
            return self.cost < other.cost
        return surely_less(self.folds, other.folds)

    def is_likelier(self, other: "_Candidate") -> bool:
        """Return whether the evidence on as many samples is very strong for it."""
        return self.samples == other.samples and self.evidence > other.evidence + STRONG

    def shown(self, criterion: str) -> Tried:
        """Return kernel, scaling, samples, evidence and cost for the findings."""
        scale = "common" if np.ptp(self.latest.unit) == 0.0 else "joint"
        costs = {"evidence": self.evidence, criterion: self.cost}
        return Tried(self.spec.kernel.name, scale, self.samples, **costs)


def _likeliest(candidates: "Sequence[_Candidate]") -> "_Candidate":
    """Return the first candidate, or a later one that is surely likelier and no worse on folds."""
    best = candidates[0]
    for one in candidates[1:]:
        if one.is_likelier(best) and one.cost <= best.cost:
            best = one
    return best


def _least_error(problem: Problem, first: int) -> tuple[int, Problem, Floats]:
    """Return index, problem and log errors by fold of the best noise factor on blocks left out.

    The search goes from the first factor to its neighbours, as long as the error falls.
    """
    errors: dict[int, Floats] = {}

    def error(factor: int) -> float:
        if factor not in errors:
            errors[factor] = mean_logs(fold_errors(problem.noisier(NOISE_FACTORS[factor])))
        return typical(errors[factor])

    best = first
    for step in (1, -1):
        while best + step in range(len(NOISE_FACTORS)) and (
            error(best + step) < error(best) or not np.isfinite(error(best))
        ):
            best += step
    error(best)
    return best, problem.noisier(NOISE_FACTORS[best]), errors[best]


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
