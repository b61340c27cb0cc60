"""Problem (44) solved: exactly, or on inducing points from as many samples as there are.

Errors of neighbouring samples are correlated: torque that the kernel cannot express lasts for many
of them. Noise that was chosen on a small subset would give all samples too much weight, and more
data could make the error worse. On inducing points the noise is therefore multiplied by the factor
with the smallest error on groups of blocks left out in turn, without a further pass over the
samples.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Generic, Protocol, TypeVar

import numpy as np

from lagrangian_ff.arrays import Floats, Ints
from lagrangian_ff.effects import Inputs
from lagrangian_ff.identification.basis import Basis
from lagrangian_ff.identification.problem import Problem, rows_of
from lagrangian_ff.identification.solving.inducing import InducingPoints
from lagrangian_ff.identification.solving.low_rank import LowRank
from lagrangian_ff.identification.solving.system import System
from lagrangian_ff.kernels import States
from lagrangian_ff.kernels.dense import cross_of
from lagrangian_ff.progress import Progress, part, silent

AnySystem = TypeVar("AnySystem", bound="System | LowRank", covariant=True)

NOISE_FACTORS = (1.0, 3.0, 10.0, 30.0, 100.0, 300.0, 1000.0)
"""Factors on the noise, tried on inducing points."""


@dataclass(frozen=True)
class Posterior(Generic[AnySystem]):
    """A solved problem, for prediction, evidence and validation.

    Attributes:
        problem: that was solved.
        states: (C, N) centres of the kernel: all training states, or inducing points.
        systems: joints solved together, their basis, and the factored system.
    """

    problem: Problem
    states: States
    systems: tuple[tuple[tuple[int, ...], Basis, AnySystem], ...]

    @property
    def count(self) -> int:
        """Return S, the number of samples learned from."""
        return len(self.problem.samples)

    @property
    def system(self) -> AnySystem:
        """Return the system of all joints, of a kernel that couples them."""
        ((_, _, system),) = self.systems
        return system

    @property
    def weights(self) -> Floats:
        """Return a, (C, N), the weights of the kernel, in normalised torque."""
        out = np.empty_like(self.states.q)
        for joints, _, system in self.systems:
            out[:, list(joints)] = system.weights.reshape(len(self.states), len(joints))
        return out

    @property
    def residual(self) -> Floats:
        """Return (M, N) N·m, torque minus prediction."""
        out = np.empty((self.count, self.states.joints))
        for joints, _, system in self.systems:
            out[:, list(joints)] = system.residual.reshape(self.count, len(joints))
        return out * self.problem.unit

    def torque(self, x: Inputs) -> Floats:
        """Return (M, N) N·m, predicted for any states."""
        kernel = self.problem.kernel.learned(self.states, self.weights)
        effects = self.problem.basis.torque(x, self.coefficients).values()
        rigid = kernel.torque(States(x.q, x.qd, x.qdd)) * self.problem.unit
        return np.asarray(sum(effects, rigid))

    @property
    def coefficients(self) -> Floats:
        """Return b, (B,), the effects' parameters, in physical units."""
        return self._gather([system.coefficients for _, _, system in self.systems])

    @property
    def deviations(self) -> Floats:
        """Return (B,) the standard deviations of b under the model's noise."""
        return self._gather([system.deviations for _, _, system in self.systems])

    @property
    def log_evidence(self) -> float:
        """Return the restricted log evidence of all torques in N·m, in nats.

        It counts the unit of each torque, so that it can be compared between scalings.
        """
        moving = np.sum(~self.problem.samples.x.rest, axis=0)
        by_unit = moving * np.log(self.problem.unit)
        return sum(
            system.log_evidence - float(np.sum(by_unit[list(joints)]))
            for joints, _, system in self.systems
        )

    def left_out(self, groups: Sequence[Ints]) -> Floats:
        """Return (M, N) residuals in N·m of groups of samples left out, from the factor at hand.

        Args:
            groups: samples that are left out together; a sample in none of them has NaN.
        """
        residual = np.full((self.count, self.states.joints), np.nan)
        for joints, _, system in self.systems:
            width, columns = len(joints), np.array(joints)
            rows = [rows_of(group, width) for group in groups]
            for group, left in zip(groups, system.left_out(rows), strict=True):
                residual[np.ix_(group, columns)] = left.residual.reshape(-1, width)
        return residual * self.problem.unit

    def changed(self, groups: Sequence[Ints]) -> Floats:
        """Return (groups, B) the effects' parameters without each group of samples."""
        changed = np.tile(self.coefficients, (len(groups), 1))
        for joints, basis, system in self.systems:
            rows = [rows_of(group, len(joints)) for group in groups]
            changed[:, self._places(basis)] += system.changes(rows)[:, : basis.size]
        return changed

    def left_out_deviation(self, groups: Sequence[Ints]) -> Floats:
        """Return the standard deviation that the model expects of `left_out`, all weights being 1.

        Args:
            groups: see `left_out`.

        Returns:
            (M, N) N·m, NaN for a sample in no group, or one of a large group that was skipped.
        """
        found = np.full((self.count, self.states.joints), np.nan)
        doubt = self.problem.variances * (1.0 / self.problem.samples.weights - 1.0)
        for joints, _, system in self.systems:
            width, columns = len(joints), np.array(joints)
            rows = [rows_of(group, width) for group in groups]
            variances = system.left_out_variance(rows)
            for group, variance in zip(groups, variances, strict=True):
                own = variance.reshape(-1, width) - doubt[np.ix_(group, columns)]
                found[np.ix_(group, columns)] = np.sqrt(system.amplitude * own)
        return found * self.problem.unit

    def variance(self, x: Inputs) -> "Variance":
        """Return the variance of the torques of M states."""
        states = States(x.q, x.qd, x.qdd)
        kernel, unit = self.problem.kernel, self.problem.unit
        prior = kernel.variance(states)
        known, added, scale, noise = np.empty((4, *x.q.shape))
        for joints, basis, system in self.systems:
            rows = list(joints)
            cross = cross_of(kernel, states, self.states, joints)
            design = basis.design(x)[:, rows, :] / unit[rows][None, :, None]
            found = system.variance(cross.T, design.reshape(len(x) * len(rows), -1))
            known[:, rows], added[:, rows] = (part.reshape(len(x), -1) for part in found)
            scale[:, rows] = system.prior_amplitude * unit[rows] ** 2
            noise[:, rows] = system.amplitude * unit[rows] ** 2
        noise *= self.problem.variances
        left = np.maximum(prior - known, 0.0)
        return Variance(prior * scale, left * scale, added * scale, noise)

    def _gather(self, values: list[Floats]) -> Floats:
        out = np.empty(self.problem.basis.size)
        for (_, basis, _), value in zip(self.systems, values, strict=True):
            out[self._places(basis)] = value[: basis.size]
        return out

    def _places(self, basis: Basis) -> Ints:
        wanted = {id(term) for term in basis.terms}
        slices = self.problem.basis.slices()
        places = [np.arange(p.start, p.stop) for term, p in slices if id(term) in wanted]
        return np.concatenate(places) if places else np.empty(0, dtype=np.int64)


@dataclass(frozen=True)
class Variance:
    """The variance of torques, in parts; every array is (M, N) in (N·m)².

    Attributes:
        prior: of the kernel before any data.  kernel: after the data.
        basis: of the effects' parameters, less what the kernel compensates.
        noise: of a measurement.
    """

    prior: Floats
    kernel: Floats
    basis: Floats
    noise: Floats

    @property
    def whole(self) -> Floats:
        """Return the variance of a torque that would be measured."""
        return self.kernel + self.basis + self.noise


class Solver(Protocol):
    """Solves one problem for one set of IRLS weights (S, N) after the other; None is 1 for all."""

    def __call__(self, weight: Floats | None, progress: Progress = silent) -> Posterior:
        """Return the posterior.

        Raises:
            NotPositiveDefiniteError: the noise is too small.
        """


def exact(
    problem: Problem,
    only: int | None = None,
    like: System | None = None,
    progress: Progress = silent,
    grams: Mapping[tuple[int, ...], Floats] | None = None,
) -> Posterior[System]:
    """Solve (44) with one Cholesky factor a system.

    Args:
        only: a joint, if joints are learned apart; None is all.
        like: solved with the same samples, kernel and noise, whose factor is taken; coupled.
        progress: receives the share done, 0 to 1.
        grams: Gram matrix of each system, if known; kept as they are.

    Raises:
        NotPositiveDefiniteError: the noise is too small.
    """
    systems = []
    wanted = [joints for joints in problem.together if only is None or only in joints]
    for number, joints in enumerate(wanted):
        rows = problem.rows(joints)
        if like is not None:
            system = like.of(rows.design(), rows.target)
        else:
            gram = problem.gram(joints) if grams is None else grams[joints].copy()
            system = System.factor(gram, rows.noise, rows.design(), rows.target, rows.stuck)
        systems.append((joints, problem.basis.of_joints(joints), system))
        progress((number + 1) / len(wanted), "fitting")
    return Posterior(problem, problem.samples.states, tuple(systems))


def exact_solver(problem: Problem) -> Solver:
    """Return a solver of a problem, exact, its Gram matrices formed once."""
    grams = {joints: problem.gram(joints) for joints in problem.together}

    def solve(weight: Floats | None, progress: Progress = silent) -> Posterior[System]:
        return exact(problem.weighted(weight), progress=progress, grams=grams)

    return solve


def rebased(found: Posterior[System], basis: Basis) -> Posterior[System]:
    """Return the posterior with other shapes of the effects; the Gram matrix is the same."""
    problem = found.problem.having(basis=basis)
    systems = []
    for joints, _, system in found.systems:
        rows = problem.rows(joints)
        systems.append((joints, basis.of_joints(joints), system.of(rows.design(), rows.target)))
    return replace(found, problem=problem, systems=tuple(systems))


def inducing_solver(problem: Problem, at: States, groups: Sequence[Ints]) -> Solver:
    """Return a solver of a problem on inducing points; see `low_rank`.

    Args:
        problem: complete, but for the size of the noise.
        at: (C, N) the inducing points.
        groups: samples that are left out together; every sample in one of them.

    Raises:
        NotPositiveDefiniteError: the Gram matrix of the inducing points is not finite.
    """
    points = [InducingPoints.of(problem.kernel, at, joints) for joints in problem.together]

    def solve(weight: Floats | None, progress: Progress = silent) -> Posterior[LowRank]:
        weighted = problem.weighted(weight)
        systems, noise = [], problem.noise.copy()
        for number, (joints, own) in enumerate(zip(problem.together, points, strict=True)):
            share = part(progress, number / len(points), (number + 1) / len(points))
            system = LowRank.of(own, weighted.rows(joints), groups, share)
            if len(groups) > 1:
                system = _tempered(system)
            noise[list(joints)] *= system.factor
            systems.append((joints, problem.basis.of_joints(joints), system))
        return Posterior(weighted.having(noise=noise), at, tuple(systems))

    return solve


def _tempered(system: LowRank) -> LowRank:
    """Return the system with the noise that leaves the smallest error on groups left out."""
    best, least = system, np.inf
    for factor in NOISE_FACTORS:
        tried = replace(system, factor=factor)
        error = tried.error_left_out
        if error >= least:
            break
        best, least = tried, error
    return best
