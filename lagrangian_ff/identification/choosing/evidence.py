"""The log evidence of a problem over the logarithms of its hyperparameters, and its maximum.

With A = G⁻¹Φ (Φᵀ G⁻¹ Φ)⁻¹, P as in `system`, a = P y and s² the amplitude, the restricted log
evidence E falls with the Gram matrix and the basis as

    −2 ∂E/∂G = P − a aᵀ / s²,        −∂E/∂Φ = A − a bᵀ / s².

Its curvature is taken as the average information ½ (G'_i a)ᵀ P (G'_j a) / s² of two numbers of the
Gram matrix, less what the amplitude takes, and (Φ'_i b)ᵀ P (Φ'_j b) / s² of two shapes (Gilmour,
Thompson and Cullis, Biometrics 51, 1995): it costs products with vectors only, and a dozen steps
arrive. A weak prior holds hyperparameters that the torques leave open.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import partial
from operator import attrgetter

import numpy as np
from scipy.linalg import solve_triangular

from lagrangian_ff.arrays import Floats
from lagrangian_ff.effects import Inputs, Shape
from lagrangian_ff.identification.basis import Basis, Term
from lagrangian_ff.identification.choosing.levenberg_marquardt import (
    ENOUGH,
    Density,
    Derivatives,
    HyperPrior,
)
from lagrangian_ff.identification.problem import Problem
from lagrangian_ff.identification.solving.posterior import Posterior, exact
from lagrangian_ff.identification.solving.solution import with_least_noise
from lagrangian_ff.identification.solving.system import System
from lagrangian_ff.kernels import DifferentiableKernel
from lagrangian_ff.kernels.threads import one_blas_thread
from lagrangian_ff.progress import Progress, silent

SHAPE_STEP = 1e-3
FAR, NEAR = 1.0, 0.1
"""Damping of the first step from the start, and from where fewer samples have led."""


@dataclass(frozen=True)
class Logarithms:
    """The hyperparameters of a problem as K logarithms: kernel, noise by joint, effects' shapes.

    Attributes:
        like: a problem that has them.
        shapes: whether the effects' shapes are included.
    """

    like: Problem
    shapes: bool = True

    def of(self, problem: Problem) -> Floats:
        """Return the logarithms (K,) of a problem."""
        parts = [*numbers(kernel_of(problem)).values(), problem.noise]
        parts += [
            np.array([term.shape[shape.name] - shape.zero])
            for _, term, shape in self._shapes(problem.basis)
        ]
        return np.asarray(np.log(np.concatenate(parts)))

    def at(self, point: Floats) -> Problem:
        """Return the problem with the hyperparameters of a point (K,)."""
        values, first = np.exp(point), 0
        held = {}
        for name, value in numbers(kernel_of(self.like)).items():
            held[name] = values[first : first + len(value)]
            first += len(value)
        noise = values[self.noise]
        terms = list(self.like.basis.terms)
        logs = point[self.noise.stop :].tolist()
        for (number, _, shape), log in zip(self._shapes(self.like.basis), logs, strict=True):
            moved = {**terms[number].shape, shape.name: shape.value(log)}
            terms[number] = replace(terms[number], shape=moved)
        kernel = self.like.kernel.replace(**held)
        return self.like.having(kernel=kernel, noise=noise, basis=Basis(tuple(terms)))

    @property
    def prior(self) -> HyperPrior:
        """Return the prior about the problem's own hyperparameters."""
        kernel, middle = kernel_of(self.like), self.of(self.like)
        rare = [np.full(len(v), name in kernel.variances) for name, v in numbers(kernel).items()]
        variances = np.zeros(len(middle))
        variances[: self.noise.start] = np.concatenate(rare)
        return HyperPrior(middle, variances)

    @property
    def noise(self) -> slice:
        """Return the place of the joints' noise among the logarithms."""
        first = sum(len(value) for value in numbers(kernel_of(self.like)).values())
        return slice(first, first + len(self.like.noise))

    @property
    def ends(self) -> tuple[Floats, Floats]:
        """Return (K,) the lowest and the highest logarithms: only shapes have a range."""
        low, high = np.full((2, len(self.of(self.like))), [[-np.inf], [np.inf]])
        for place, (_, _, shape) in enumerate(self._shapes(self.like.basis), self.noise.stop):
            low[place], high[place] = shape.logarithm(shape.low), shape.logarithm(shape.high)
        return low, high

    def _shapes(self, basis: Basis) -> Iterator[tuple[int, Term, Shape]]:
        return shapes_of(basis) if self.shapes else iter(())


def shapes_of(basis: Basis) -> Iterator[tuple[int, Term, Shape]]:
    """Yield every shape with the number of its term and the term, effect by effect."""
    effects = {term.effect.name: term.effect for term in basis.terms}
    for effect in effects.values():
        for shape in effect.shapes:
            for number, term in enumerate(basis.terms):
                if term.effect.name == effect.name:
                    yield number, term, shape


def maximise_evidence(
    problem: Problem,
    steps: int,
    prior: HyperPrior,
    progress: Progress = silent,
    *,
    shapes: bool = True,
    enough: float = ENOUGH,
    damping: float = FAR,
    least_noise: float = 0.0,
) -> Posterior[System]:
    """Return the posterior with the hyperparameters of largest evidence; see `Density.maximised`.

    Args:
        problem: with the hyperparameters to begin with; its kernel is differentiable.
        steps: at most.  prior: of the logarithms.
        progress: receives the share done, 0 to 1.
        shapes: whether the effects' shapes are chosen as well.
        enough: nats that a step must bring for another to be tried.
        damping: of the first step, see `FAR`.
        least_noise: of each joint, as a share of the kernel's mean variance.

    Raises:
        NotPositiveDefiniteError: the Gram matrix is not positive definite to begin with.
    """
    logarithms = Logarithms(problem, shapes)

    def at(point: Floats) -> Posterior[System]:
        return exact(logarithms.at(point))

    def inside(point: Floats) -> Floats:
        point = np.clip(point, *logarithms.ends)
        if least_noise:
            # To refuse a step for one joint's noise would hold up all other numbers.
            point[logarithms.noise] = np.log(loud(logarithms.at(point), least_noise).noise)
        return point

    def report(step: int) -> None:
        progress(step / steps, "maximising the evidence")

    evidence, by_logarithm = attrgetter("log_evidence"), partial(derivatives, shapes=shapes)
    density = Density(prior, at, evidence, by_logarithm, inside)
    # Threads cost more than they bring on matrices as small as these.
    with one_blas_thread():
        return density.maximised(logarithms.of(problem), steps, report, enough, damping)[1]


def loud(problem: Problem, least: float) -> Problem:
    """Return the problem with at least this share of the kernel's mean variance as noise."""
    variance = problem.kernel.variance(problem.samples.states).mean()
    return problem.having(noise=np.maximum(problem.noise, least * variance))


def solvable(problem: Problem) -> Problem:
    """Return the problem with the least noise added that makes its Gram matrix positive definite.

    Raises:
        NotPositiveDefiniteError: no noise does.
    """

    def tried(factor: float) -> Problem:
        noisier = problem.noisier(factor)
        exact(noisier)
        return noisier

    with one_blas_thread():
        return with_least_noise(tried)[0]


def derivatives(found: Posterior[System], *, shapes: bool = True) -> Derivatives:
    """Return the derivatives of the log evidence, in the order of `Logarithms`."""
    gram = _by_gram(found)
    if not shapes:
        return gram
    by_shape, changes = _by_shapes(found)
    first, size = len(gram.gradient), len(gram.gradient) + len(by_shape)
    curvature = np.zeros((size, size))
    curvature[:first, :first] = gram.curvature
    if changes:
        white = projected(found.system, np.array(changes))
        curvature[first:, first:] = (white.T @ white) / found.system.amplitude
    return Derivatives(np.concatenate([gram.gradient, by_shape]), curvature)


def _by_gram(found: Posterior[System]) -> Derivatives:
    """Return those by the kernel's numbers, in their order, and by the noise of each joint."""
    system, problem, states = found.system, found.problem, found.states
    kernel, second = kernel_of(problem), problem.second()
    by_gram = system.slope_by_gram()
    each = system.noise.reshape(len(states), -1)
    diagonal = (np.diag(by_gram).reshape(each.shape) * each).sum(axis=0)
    diagonal -= system.stuck.reshape(each.shape).sum(axis=0)
    if second is not None:
        by_gram *= 1.0 + np.outer(second, second)
    contracted = kernel.contract(states, by_gram, system.weights)
    values = numbers(kernel)
    totals = [contracted[name].total * value for name, value in values.items()]
    products = [contracted[name].product * value[:, None] for name, value in values.items()]
    if second is not None:
        again = kernel.contract(states, by_gram, system.weights * second)
        for product, (name, value) in zip(products, values.items(), strict=True):
            product += again[name].product * value[:, None] * second
    own = np.tile(np.eye(each.shape[1]), len(states)) * each.ravel() * system.weights
    gradient = -0.5 * np.concatenate([*totals, diagonal])
    moved = np.vstack([*products, own])
    white = projected(system, moved)
    shared = 0.5 * moved @ system.weights / system.amplitude
    curvature = 0.5 * (white.T @ white) / system.amplitude
    curvature -= np.outer(shared, shared) * 2.0 / system.degrees
    return Derivatives(gradient, curvature)


def _by_shapes(found: Posterior[System]) -> tuple[list[float], list[Floats]]:
    """Return the gradient by the shapes, and (S N,) the change of the torque with each."""
    problem, system = found.problem, found.system
    x = problem.samples.x
    by_design = system.slope_by_design().reshape(len(x), x.joints, -1)
    slices = problem.basis.slices()
    gradient, changes = [], []
    for number, term, shape in shapes_of(problem.basis):
        place = slices[number][1]
        change = _change(term, shape, x) / problem.unit[term.joint]
        gradient.append(-float(np.sum(by_design[:, term.joint, place] * change)))
        torque = np.zeros(x.q.shape)
        torque[:, term.joint] = change @ system.coefficients[place]
        changes.append(torque.ravel())
    return gradient, changes


def _change(term: Term, shape: Shape, x: Inputs) -> Floats:
    """Return (S, P) the derivative of a term's columns by the logarithm of one shape."""
    present = shape.logarithm(term.shape[shape.name])
    up, down = (
        replace(term, shape={**term.shape, shape.name: shape.value(present + step)}).columns(x)
        for step in (SHAPE_STEP, -SHAPE_STEP)
    )
    return np.asarray((up - down) / (2.0 * SHAPE_STEP))


def projected(system: System, rows: Floats) -> Floats:
    """Return W, (n, K), with Wᵀ W = rows P rowsᵀ, for rows (K, n)."""
    white = solve_triangular(system.upper, rows.T, trans=1, check_finite=False)
    fit = system.covariance @ (system.white_design.T @ white)
    return np.asarray(white - system.white_design @ fit)


def numbers(kernel: DifferentiableKernel) -> dict[str, Floats]:
    """Return the kernel's numbers that the evidence is maximised over, by name.

    A part whose weight is 0 is not there and stays so, as gravity where the effort has none.
    """
    every = {name: kernel.hyperparameters[name] for name in kernel.differentiable}
    return {name: value for name, value in every.items() if value.any()}


def kernel_of(problem: Problem) -> DifferentiableKernel:
    """Return the kernel, which must be differentiable."""
    assert isinstance(problem.kernel, DifferentiableKernel)
    return problem.kernel
