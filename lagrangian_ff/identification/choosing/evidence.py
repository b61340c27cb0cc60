"""Climbing the log evidence of a model: its kernel's numbers, its noise, its effects' shapes."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from threadpoolctl import threadpool_limits

from lagrangian_ff.identification.basis import Term
from lagrangian_ff.identification.choice import Choice, Scaling
from lagrangian_ff.identification.choosing.ascent import (
    Hill,
    Slopes,
    numbers,
    projected,
    slopes_by_gram,
)
from lagrangian_ff.identification.choosing.belief import Belief
from lagrangian_ff.identification.choosing.training import TrainingSet
from lagrangian_ff.identification.solving.equations import fit_basis
from lagrangian_ff.identification.solving.fit import Fit
from lagrangian_ff.identification.solving.solution import with_least_noise
from lagrangian_ff.identification.spec import Spec
from lagrangian_ff.kernels import DifferentiableKernel
from lagrangian_ff.progress import Progress, silent

Floats = NDArray[np.float64]

SHAPE_STEP = 1e-3
ENOUGH = 0.5
"""Nats that a step must bring for another to be tried: what a choice is judged by changes less."""
FAR, NEAR = 1.0, 0.1
"""Damping of the first step from the start, and from where fewer samples have led."""


def climb(
    spec: Spec,
    start: Choice,
    data: TrainingSet,
    scaling: Scaling,
    stages: Sequence[tuple[int, int]],
    progress: Progress = silent,
    first: Choice | None = None,
) -> tuple[Choice, float]:
    """Climb the log evidence from a start; see `ascent`.

    Args:
        spec: kernel family and effects; the kernel is differentiable.
        start: where the prior of every logarithm has its middle.
        data: the samples.
        scaling: how torques are normalised.
        stages: (samples used, steps at most) one after the other, few samples first.
        progress: told the share done.
        first: where to begin, if not at the start.

    Returns:
        The choice at the top, and the log evidence there of the last stage's samples.

    Raises:
        NotPositiveDefiniteError: even with much more noise the start has no factor.
    """
    total, done = sum(steps for _, steps in stages), 0
    path = _Path(spec, start)
    point = path.middle if first is None else _Path(spec, first).middle
    evidence = -np.inf
    # Threads cost more than they bring on matrices as small as these.
    with threadpool_limits(1):
        for samples, steps in stages:
            part = data.thinned(samples)

            def told(step: int, before: int = done) -> None:
                progress((before + step) / total, "climbing the evidence")

            def go(at: Floats, part: TrainingSet = part) -> Fit:
                choice = path.at(at)
                basis = choice.basis(spec, part.x.joints)
                return fit_basis(basis, choice, part.x, part.tau, scaling, part.trust)

            def slopes(fitted: Fit, part: TrainingSet = part) -> Slopes:
                return slopes_of(fitted, part)

            hill = Hill(path.belief, go, lambda fitted: fitted.log_evidence, slopes, *path.ends)
            damping = FAR if np.array_equal(point, path.middle) else NEAR
            point, fitted = hill.climb(_footing(point, path, go), steps, told, ENOUGH, damping)
            evidence = fitted.log_evidence
            done += steps
    return path.at(point), float(evidence)


def _footing(point: Floats, path: "_Path", go: Callable[[Floats], Fit]) -> Floats:
    """The point with the least noise added that there is a factor with.

    Raises:
        NotPositiveDefiniteError: there is none.
    """

    def raised(factor: float) -> Floats:
        tried = point.copy()
        tried[path.noise] += np.log(factor)
        go(tried)
        return tried

    return with_least_noise(raised)[0]


@dataclass(frozen=True)
class _Path:
    """A choice as a vector of logarithms: the kernel's numbers, the noise, the effects' shapes."""

    spec: Spec
    start: Choice

    @property
    def middle(self) -> Floats:
        """(K,) of the start."""
        parts = [*numbers(_kernel(self.start)).values(), self.start.noise]
        parts += [v for shapes in self.start.shapes.values() for v in shapes.values()]
        return np.asarray(np.log(np.concatenate(parts)))

    @property
    def belief(self) -> Belief:
        """About the start."""
        kernel, middle = _kernel(self.start), self.middle
        rare = [np.full(len(v), name in kernel.variances) for name, v in numbers(kernel).items()]
        variances = np.zeros(len(middle))
        variances[: self.noise.start] = np.concatenate(rare)
        return Belief(middle, variances)

    @property
    def noise(self) -> slice:
        """Where the noise of each joint stands."""
        first = sum(len(value) for value in numbers(_kernel(self.start)).values())
        return slice(first, first + len(self.start.noise))

    @property
    def ends(self) -> tuple[Floats, Floats]:
        """(K,) the lowest and the highest logarithms: shapes have a range, nothing else has."""
        ranges = {e.name: {s.name: (s.low, s.high) for s in e.shapes} for e in self.spec.effects}
        low, high = np.full((2, len(self.middle)), [[-np.inf], [np.inf]])
        first = self.noise.stop
        for effect, named in self.start.shapes.items():
            for shape, values in named.items():
                own = slice(first, first + len(values))
                low[own], high[own] = np.log(ranges[effect][shape])
                first = own.stop
        return low, high

    def at(self, point: Floats) -> Choice:
        """The choice at a point."""
        left = np.exp(point)

        def take(like: Floats) -> Floats:
            nonlocal left
            values, left = left[: len(like)], left[len(like) :]
            return values

        held = numbers(_kernel(self.start))
        kernel = self.start.kernel.replace(**{name: take(value) for name, value in held.items()})
        noise = take(self.start.noise)
        shapes = {
            effect: {name: take(value) for name, value in named.items()}
            for effect, named in self.start.shapes.items()
        }
        return Choice(kernel, noise, shapes)


def slopes_of(fitted: Fit, part: TrainingSet) -> Slopes:
    """By all logarithms of a choice, in the order of `_Path`."""
    ((_, _, system),) = fitted.systems
    noise = fitted.choice.noise * fitted.scaling.noise**2
    gram = slopes_by_gram(system, _kernel(fitted.choice), fitted.states, noise, trust=fitted.trust)
    by_shape, changes = _by_shapes(fitted, part)
    first, size = len(gram.slope), len(gram.slope) + len(by_shape)
    information = np.zeros((size, size))
    information[:first, :first] = gram.information
    if changes:
        white = projected(system, np.array(changes))
        information[first:, first:] = (white.T @ white) / system.amplitude
    return Slopes(np.concatenate([gram.slope, by_shape]), information)


def _by_shapes(fitted: Fit, part: TrainingSet) -> tuple[list[float], list[Floats]]:
    """Slopes by the shapes, and (n,) how the basis' torque changes with each."""
    ((_, basis, system),) = fitted.systems
    slopes, changes = [], []
    by_design = system.slope_by_design().reshape(len(part.x), part.x.joints, -1)
    for effect, named in fitted.choice.shapes.items():
        for shape in named:
            for term, place in basis.slices():
                if term.effect.name == effect:
                    change = _change(term, shape, part) / fitted.scaling.unit[term.joint]
                    slopes.append(-float(np.sum(by_design[:, term.joint, place] * change)))
                    torque = np.zeros(part.x.q.shape)
                    torque[:, term.joint] = change @ system.coefficients[place]
                    changes.append(torque.ravel())
    return slopes, changes


def _kernel(choice: Choice) -> DifferentiableKernel:
    assert isinstance(choice.kernel, DifferentiableKernel)
    return choice.kernel


def _change(term: Term, shape: str, part: TrainingSet) -> Floats:
    """(M, P) how a term's columns change with the logarithm of one of its shapes."""
    value = term.shape[shape]
    up, down = (
        replace(term, shape={**term.shape, shape: value * np.exp(step)}).columns(part.x)
        for step in (SHAPE_STEP, -SHAPE_STEP)
    )
    return np.asarray((up - down) / (2.0 * SHAPE_STEP))
