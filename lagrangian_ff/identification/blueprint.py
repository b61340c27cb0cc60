"""All that a model is made from, and its solution, exact or on inducing points."""

from dataclasses import dataclass, replace

import numpy as np

from lagrangian_ff.arrays import Flags, Floats, Ints
from lagrangian_ff.effects import Inputs
from lagrangian_ff.identification.predicting import TorqueModel
from lagrangian_ff.identification.problem import Prior, Problem
from lagrangian_ff.identification.samples import Samples, evenly, groups
from lagrangian_ff.identification.settings import Settings
from lagrangian_ff.identification.solving.posterior import (
    Posterior,
    exact,
    exact_solver,
    inducing_solver,
)
from lagrangian_ff.identification.solving.robust import (
    ENOUGH,
    FEW_STEPS,
    ROUGH,
    STEPS,
    heavy_tailed,
    huber,
)
from lagrangian_ff.identification.solving.solution import (
    NotPositiveDefiniteError,
    no_factor,
    with_least_noise,
)
from lagrangian_ff.kernels import States
from lagrangian_ff.progress import Progress, part, silent
from lagrangian_ff.recording.motion import Motion
from lagrangian_ff.sampling import usual_step

SUBSET = 500
"""Samples that shapes and noise are searched on, for a model on inducing points."""
INDEPENDENT_SECONDS = 1.0
"""Samples closer than this do not count as independent in intervals."""


@dataclass(frozen=True)
class Blueprint:
    """All that a model is made from.

    Its methods take `inputs`: all of the data as effects see it.

    Attributes:
        name: kernel and effects.
        prior: kernel, noise, scaling and basis.
        data: the motion learned from and that held out, at the rate that is kept.
        trained: (K,) which of its samples may be learned from.
        index: (C,) those the kernel is built on.
        seen: (S,) those that determine the coefficients; the same where the fit is exact.
        settings: that all this was chosen with.
        weight: (S, N) IRLS weights of `seen` that Huber's loss begins with; None for squares.
    """

    name: str
    prior: Prior
    data: Motion
    trained: Flags
    index: Ints
    seen: Ints
    settings: Settings
    weight: Floats | None = None

    @classmethod
    def of(cls, model: TorqueModel) -> "Blueprint":
        """Return the blueprint of a model.

        Raises:
            ModelError: its record has unknown or invalid settings.
        """
        samples = model.trained, model.index, model.seen
        settings = Settings.from_record(model.record.get("settings", {}))
        return cls(model.name, model.prior, model.data, *samples, settings, model.irls_weight)

    @property
    def exact(self) -> bool:
        """Return whether the kernel is built on all that is learned from."""
        return np.array_equal(self.index, self.seen)

    def problem(self, samples: Samples) -> Problem:
        """Return the problem of some samples."""
        return Problem(samples, self.prior)

    def whole(self, inputs: Inputs) -> Problem:
        """Return the problem of all that is learned from, without weights."""
        return self.problem(Samples(inputs.take(self.seen), self.data.tau[self.seen]))

    def subset(self, inputs: Inputs, most: int | None = None) -> Problem:
        """Return the problem of a subset of the samples, small enough to be solved exactly.

        Shapes and noise are searched on it, with `most` samples at most. Outliers hardly count.
        """
        at = np.arange(len(self.seen)) if self.exact else evenly(len(self.seen), SUBSET)
        at = at if most is None else at[evenly(len(at), most)]
        index = self.seen[at]
        weight = None if self.weight is None else heavy_tailed(self.weight[at])
        tau, folds = self.data.tau[index], self.folds(index)
        return self.problem(Samples(inputs.take(index), tau, folds, weight))

    def blocks(self, samples: Ints) -> Ints:
        """Return (F,) the block of time that each training sample lies in, counted from 0."""
        training = self.data.take(self.trained)
        block = np.full(len(self.data), -1)
        block[self.trained] = training.blocks(self.settings.block_seconds)
        return np.asarray(np.unique(block[samples], return_inverse=True)[1], dtype=np.int64)

    def folds(self, samples: Ints) -> Ints:
        """Return (F,) the fold that each training sample is left out with."""
        return self.blocks(samples) % self.settings.folds

    @property
    def folded(self) -> list[Ints]:
        """Return the samples learned from, fold by fold."""
        return groups(self.folds(self.seen))

    @property
    def apart(self) -> list[Ints]:
        """Return the samples learned from, in the smallest groups that a fit can leave out.

        These are blocks of time; on inducing points, which sum over folds only, they are the folds.
        """
        return groups(self.blocks(self.seen)) if self.exact else self.folded

    @property
    def seconds(self) -> Ints:
        """Return (S,) the second that each sample lies in; seconds count as independent."""
        return np.asarray(self.data.blocks(INDEPENDENT_SECONDS)[self.seen])


@dataclass(frozen=True)
class Solved:
    """A blueprint solved.

    Attributes:
        posterior: of the model.
        weighed: the posterior that intervals are made from: an outlier counts no more than others.
        threshold: (N,) N·m, beyond which Huber's loss is linear; None for squares.
        prior: with the noise of the subset problem that it was chosen on.
        notes: sentences for people on noise that was added and on inducing points.
    """

    posterior: Posterior
    weighed: Posterior
    threshold: Floats | None
    prior: Prior
    notes: tuple[str, ...]


def solve(blueprint: Blueprint, inputs: Inputs, progress: Progress = silent) -> Solved:
    """Solve (44), with the least noise added that makes the Gram matrix positive definite.

    Args:
        inputs: all of the data as effects see it.
        progress: receives the share done, 0 to 1.

    Raises:
        ModelError: there is no factor even with much more noise.
    """

    def solved(factor: float) -> Solved:
        noisier = replace(blueprint, prior=blueprint.prior.noisier(factor))
        posterior, weighed, threshold = _with_loss(noisier, inputs, progress)
        notes = () if blueprint.exact else (_inducing(noisier, posterior),)
        if factor != 1.0:
            raised = (
                f"the noise is taken {factor:g} times as large as was chosen: with less, the Gram "
                f"matrix of {len(blueprint.index)} samples has no Cholesky factor"
            )
            notes = (raised, *notes)
        return Solved(posterior, weighed, threshold, noisier.prior, notes)

    try:
        return with_least_noise(solved)[0]
    except NotPositiveDefiniteError as error:
        samples, seen = f"{len(blueprint.index)} samples", blueprint.seen
        raise no_factor(samples, inputs.qd[seen], inputs.qdd[seen]) from error


def _with_loss(
    blueprint: Blueprint, inputs: Inputs, progress: Progress
) -> tuple[Posterior, Posterior, Floats | None]:
    """Return `Solved.posterior`, `Solved.weighed` and `Solved.threshold`."""
    problem, weight = blueprint.whole(inputs), blueprint.weight
    if blueprint.exact and weight is None:
        found: Posterior = exact(problem, progress=progress)
        return found, found, None
    if blueprint.exact:
        solver, enough, steps = exact_solver(problem), ENOUGH, STEPS
    else:
        at = blueprint.data.take(blueprint.index)
        solver = inducing_solver(problem, States.of(at.q, at.qd, at.qdd), blueprint.folded)
        enough, steps = ROUGH, FEW_STEPS
    if weight is None:
        found = solver(None, progress)
        return found, found, None
    robust = huber(solver, weight, None, enough, steps, part(progress, 0.0, 0.9))
    weights = heavy_tailed(robust.posterior.problem.samples.weights)
    weighed = solver(weights, part(progress, 0.9, 1.0))
    return robust.posterior, weighed, robust.threshold


def _inducing(blueprint: Blueprint, posterior: Posterior) -> str:
    raised = np.unique(np.round(posterior.problem.noise / blueprint.prior.noise)).astype(int)
    rate = 1.0 / usual_step(blueprint.data.time)
    shown = " to ".join(str(factor) for factor in dict.fromkeys([raised.min(), raised.max()]))
    return (
        f"learned from all {len(blueprint.seen)} training samples at {rate:.3g} Hz, with a "
        f"kernel on {len(blueprint.index)} of them as inducing points; blocks left out ask for "
        f"{shown} times the noise variance of few samples, since neighbouring samples err alike"
    )
