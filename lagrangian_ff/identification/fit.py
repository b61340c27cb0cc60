"""Fitting the semi-parametric model (44) with every hyperparameter given."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Generic, TypeVar

import numpy as np
from numpy.typing import NDArray

from lagrangian_ff.effects import Inputs
from lagrangian_ff.identification.basis import Basis, Term
from lagrangian_ff.identification.low_rank import LowRank
from lagrangian_ff.identification.rows import Rows, rows_of
from lagrangian_ff.identification.spec import Spec
from lagrangian_ff.identification.system import System
from lagrangian_ff.kernels import CoupledKernel, IndependentKernel, Kernel, States

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Solved = TypeVar("Solved", bound="System | LowRank", covariant=True)


@dataclass(frozen=True)
class Choice:
    """Everything about a model that is not linear in the torques.

    Attributes:
        kernel: with its hyperparameters.
        noise: (N,) variance of each normalised torque, γ M of (42) in the kernel's units.
        shapes: for each effect that has them, (N,) of each shape parameter.
    """

    kernel: Kernel
    noise: Floats
    shapes: Mapping[str, Mapping[str, Floats]]

    def basis(self, spec: Spec, joints: int) -> Basis:
        """Every effect of the model on every joint, joint by joint."""
        return Basis(
            tuple(
                Term(
                    effect,
                    joint,
                    {name: float(v[joint]) for name, v in self.shapes.get(effect.name, {}).items()},
                )
                for joint in range(joints)
                for effect in spec.effects
            )
        )


@dataclass(frozen=True)
class Scaling:
    """How torques are normalised before the kernel sees them.

    Attributes:
        unit: (N,) N·m that count as one; undone on the way out.
        noise: (N,) relative standard deviation of the noise between joints, in those units.
    """

    unit: Floats
    noise: Floats

    @classmethod
    def of(cls, tau: Floats, per_joint: bool = True) -> "Scaling":
        """Per joint, each torque is divided by its own spread; else all by the largest.

        With one unit for all joints the predicted torques still derive from one Lagrangian, and
        the noise is taken in proportion to each joint's spread instead.
        """
        spread = np.std(tau, axis=0)
        largest = spread.max(initial=0.0) or 1.0
        spread = np.where(spread > 1e-9 * largest, spread, largest)
        if per_joint:
            return cls(spread, np.ones_like(spread))
        return cls(np.full_like(spread, largest), spread / largest)

    @property
    def spread(self) -> Floats:
        """(N,) N·m, the spread of each joint's torque."""
        return self.unit * self.noise


@dataclass(frozen=True)
class Fit(Generic[Solved]):
    """A fitted model, still in its systems: what evidence and validation are asked of.

    Attributes:
        choice: the hyperparameters.  scaling: of the torques.  basis: the effects' terms.
        states: (C, N) what the kernel is built on: all training states, or landmarks.
        samples: M, how many it was learned from.
        systems: which joints were solved together, their basis, and the factored system.
    """

    choice: Choice
    scaling: Scaling
    basis: Basis
    states: States
    samples: int
    systems: tuple[tuple[tuple[int, ...], Basis, Solved], ...]

    @property
    def weights(self) -> Floats:
        """(C, N) a: what the kernel is multiplied by, in normalised torque."""
        out = np.empty_like(self.states.q)
        for joints, _, system in self.systems:
            out[:, list(joints)] = system.weights.reshape(len(self.states), len(joints))
        return out

    @property
    def coefficients(self) -> Floats:
        """(B,) b: the effects' parameters, in physical units."""
        return self._gather([system.coefficients for _, _, system in self.systems])

    @property
    def deviations(self) -> Floats:
        """(B,) standard deviations of b if the noise were as the model says."""
        return self._gather(
            [
                np.sqrt(np.maximum(system.amplitude * np.diag(system.covariance), 0.0))
                for _, _, system in self.systems
            ]
        )

    @property
    def log_evidence(self) -> float:
        """Restricted log evidence of all torques in N·m, in nats.

        It counts the unit of each torque, so that it can be compared between scalings.
        """
        return sum(
            system.log_evidence
            - self.samples * float(np.sum(np.log(self.scaling.unit[list(joints)])))
            for joints, _, system in self.systems
        )

    def left_out(self, groups: Sequence[Ints]) -> tuple[Floats, Floats]:
        """What a fit without each group of samples would have met, from the factor at hand.

        Args:
            groups: for each, the samples left out together; every sample in at most one.

        Returns:
            (M, N) residuals in N·m, NaN where a sample is in no group; and (groups, B) the
            effects' parameters without each group.
        """
        residual = np.full((self.samples, self.states.joints), np.nan)
        changed = np.tile(self.coefficients, (len(groups), 1))
        for joints, basis, system in self.systems:
            width, columns = len(joints), np.array(joints)
            rows = [rows_of(group, width) for group in groups]
            places = self._places(basis)
            for number, (group, left) in enumerate(zip(groups, system.left_out(rows), strict=True)):
                residual[np.ix_(group, columns)] = left.residual.reshape(-1, width)
                changed[number, places] += left.change
        return residual * self.scaling.unit, changed

    def changed(self, groups: Sequence[Ints]) -> Floats:
        """(groups, B) the effects' parameters without each group of samples."""
        changed = np.tile(self.coefficients, (len(groups), 1))
        for joints, basis, system in self.systems:
            rows = [rows_of(group, len(joints)) for group in groups]
            changed[:, self._places(basis)] += system.changes(rows)
        return changed

    def left_out_deviation(self, groups: Sequence[Ints]) -> Floats:
        """What the model itself expects of the residuals of `left_out`.

        Args:
            groups: see `left_out`.

        Returns:
            (M, N) standard deviations in N·m, NaN where a sample is in no group, or is one of so
            many that it was not looked at.
        """
        found = np.full((self.samples, self.states.joints), np.nan)
        for joints, _, system in self.systems:
            width, columns = len(joints), np.array(joints)
            rows = [rows_of(group, width) for group in groups]
            variances = system.left_out_variance(rows)
            for group, variance in zip(groups, variances, strict=True):
                deviation = np.sqrt(system.amplitude * variance)
                found[np.ix_(group, columns)] = deviation.reshape(-1, width)
        return found * self.scaling.unit

    def variance(self, x: Inputs) -> "Variance":
        """How sure the model is of the torques of M states; see `Variance`."""
        states = States(x.q, x.qd, x.qdd)
        kernel, unit = self.choice.kernel, self.scaling.unit
        prior = kernel.variance(states)
        known, added, scale, noise = np.empty((4, *x.q.shape))
        for joints, basis, system in self.systems:
            rows = list(joints)
            if isinstance(kernel, CoupledKernel):
                cross = kernel.cross(states, self.states)
            else:
                assert isinstance(kernel, IndependentKernel)
                cross = kernel.cross(states, self.states, joints[0])
            design = basis.design(x)[:, rows, :] / unit[rows][None, :, None]
            found = system.variance(cross.T, design.reshape(len(x) * len(rows), -1))
            known[:, rows], added[:, rows] = (part.reshape(len(x), -1) for part in found)
            scale[:, rows] = system.prior_amplitude * unit[rows] ** 2
            noise[:, rows] = system.amplitude * unit[rows] ** 2
        noise *= self.choice.noise * self.scaling.noise**2
        left = np.maximum(prior - known, 0.0)
        return Variance(prior * scale, left * scale, added * scale, noise)

    def _gather(self, values: list[Floats]) -> Floats:
        out = np.empty(self.basis.size)
        for (_, basis, _), value in zip(self.systems, values, strict=True):
            out[self._places(basis)] = value
        return out

    def _places(self, basis: Basis) -> Ints:
        wanted = {id(term) for term in basis.terms}
        places = [np.arange(p.start, p.stop) for t, p in self.basis.slices() if id(t) in wanted]
        return np.concatenate(places) if places else np.empty(0, dtype=np.int64)


@dataclass(frozen=True)
class Variance:
    """The variance of torques, in parts; every array is (M, N) in (N·m)².

    Attributes:
        prior: of the kernel before any data.
        kernel: what the data leave of it.
        basis: of the effects' parameters, as far as the kernel does not make up for them.
        noise: of a measurement.
    """

    prior: Floats
    kernel: Floats
    basis: Floats
    noise: Floats

    @property
    def whole(self) -> Floats:
        """Of a torque that would be measured."""
        return self.kernel + self.basis + self.noise


def fit(
    spec: Spec, choice: Choice, x: States | Inputs, tau: Floats, scaling: Scaling
) -> Fit[System]:
    """Solve (44) for given hyperparameters: one Cholesky factor a system.

    Args:
        spec: the kernel's family and the effects.
        choice: hyperparameters and shapes.
        x: (M, N) training states, as inputs where an effect needs more than the state.
        tau: (M, N) N·m.
        scaling: how torques are normalised.

    Raises:
        NotPositiveDefiniteError: the noise is too small for the arithmetic.
    """
    inputs = x if isinstance(x, Inputs) else Inputs.of(x)
    return fit_basis(choice.basis(spec, inputs.joints), choice, inputs, tau, scaling)


def fit_basis(
    basis: Basis, choice: Choice, x: Inputs, tau: Floats, scaling: Scaling
) -> Fit[System]:
    """Solve (44) for a basis whose shapes are given; see `fit`.

    Raises:
        NotPositiveDefiniteError: the noise is too small for the arithmetic.
    """
    states = States(x.q, x.qd, x.qdd)
    systems = []
    for joints in joints_together(choice.kernel, states.joints):
        part, rows = rows_to_learn(basis, choice, x, tau, scaling, joints)
        gram = _gram(choice.kernel, states, joints)
        systems.append((joints, part, System.factor(gram, rows.noise, rows.design(), rows.target)))
    return Fit(choice, scaling, basis, states, len(states), tuple(systems))


def joints_together(kernel: Kernel, joints: int) -> list[tuple[int, ...]]:
    """Which joints are solved together."""
    if isinstance(kernel, CoupledKernel):
        return [tuple(range(joints))]
    return [(joint,) for joint in range(joints)]


def rows_to_learn(
    basis: Basis, choice: Choice, x: Inputs, tau: Floats, scaling: Scaling, joints: tuple[int, ...]
) -> tuple[Basis, Rows]:
    """The basis of some joints, and what a system of them learns from, normalised."""
    part, rows = basis.of_joints(joints), list(joints)
    noise = choice.noise * scaling.noise**2
    return part, Rows(
        States(x.q, x.qd, x.qdd),
        part.columns(x) / scaling.unit[part.joints],
        np.array([joints.index(joint) for joint in part.joints], dtype=np.int64),
        (tau[:, rows] / scaling.unit[rows]).ravel(),
        np.tile(noise[rows], len(x)),
    )


def _gram(kernel: Kernel, states: States, joints: tuple[int, ...]) -> Floats:
    if isinstance(kernel, CoupledKernel):
        return kernel.gram(states)
    assert isinstance(kernel, IndependentKernel)
    return np.ascontiguousarray(kernel.gram(states, joints[0]))


def with_noise(choice: Choice, relative: Floats, states: States) -> Choice:
    """The choice with its noise set relative to the kernel's mean prior variance.

    Args:
        relative: (N,) or (1,) ratio of noise variance to prior variance.
        states: (M, N) where the prior variance is taken.
    """
    prior = choice.kernel.variance(states).mean(axis=0)
    if isinstance(choice.kernel, CoupledKernel):
        prior = np.full_like(prior, prior.mean())
    prior = np.where(prior > 0.0, prior, 1.0)
    return replace(choice, noise=np.broadcast_to(relative, prior.shape) * prior)
