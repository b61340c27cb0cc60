"""A fitted model, still in its systems."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Generic, TypeVar

import numpy as np
from numpy.typing import NDArray

from lagrangian_ff.effects import Inputs
from lagrangian_ff.identification.basis import Basis
from lagrangian_ff.identification.choice import Choice, Scaling
from lagrangian_ff.identification.solving.low_rank import LowRank
from lagrangian_ff.identification.solving.rows import rows_of
from lagrangian_ff.identification.solving.system import System
from lagrangian_ff.kernels import States
from lagrangian_ff.kernels.dense import cross_of

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Solved = TypeVar("Solved", bound="System | LowRank", covariant=True)


@dataclass(frozen=True)
class Fit(Generic[Solved]):
    """A fitted model, still in its systems: what evidence and validation are asked of.

    Attributes:
        choice: the hyperparameters.  scaling: of the torques.  basis: the effects' terms.
        states: (C, N) what the kernel is built on: all training states, or landmarks.
        samples: M, how many it was learned from.
        systems: which joints were solved together, their basis, and the factored system.
        trust: (M, N) the share of its weight that each torque has in the sum of squares: its
            noise is taken 1 / trust times as large.
    """

    choice: Choice
    scaling: Scaling
    basis: Basis
    states: States
    samples: int
    systems: tuple[tuple[tuple[int, ...], Basis, Solved], ...]
    trust: Floats

    @property
    def weights(self) -> Floats:
        """(C, N) a: what the kernel is multiplied by, in normalised torque."""
        out = np.empty_like(self.states.q)
        for joints, _, system in self.systems:
            out[:, list(joints)] = system.weights.reshape(len(self.states), len(joints))
        return out

    @property
    def residual(self) -> Floats:
        """(M, N) N·m, torque minus what is predicted for it."""
        out = np.empty((self.samples, self.states.joints))
        for joints, _, system in self.systems:
            out[:, list(joints)] = system.residual.reshape(self.samples, len(joints))
        return out * self.scaling.unit

    def torque(self, x: Inputs) -> Floats:
        """(M, N) N·m, predicted for any states."""
        kernel = self.choice.kernel.learned(self.states, self.weights)
        effects = self.basis.torque(x, self.coefficients).values()
        rigid = kernel.torque(States(x.q, x.qd, x.qdd)) * self.scaling.unit
        return np.asarray(sum(effects, rigid))

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
        """What the model itself expects of the residuals of `left_out`, were all torques trusted.

        Args:
            groups: see `left_out`.

        Returns:
            (M, N) standard deviations in N·m, NaN where a sample is in no group, or is one of so
            many that it was not looked at.
        """
        found = np.full((self.samples, self.states.joints), np.nan)
        doubt = self.choice.noise * self.scaling.noise**2 * (1.0 / self.trust - 1.0)
        for joints, _, system in self.systems:
            width, columns = len(joints), np.array(joints)
            rows = [rows_of(group, width) for group in groups]
            variances = system.left_out_variance(rows)
            for group, variance in zip(groups, variances, strict=True):
                own = variance.reshape(-1, width) - doubt[np.ix_(group, columns)]
                found[np.ix_(group, columns)] = np.sqrt(system.amplitude * own)
        return found * self.scaling.unit

    def variance(self, x: Inputs) -> "Variance":
        """How sure the model is of the torques of M states; see `Variance`."""
        states = States(x.q, x.qd, x.qdd)
        kernel, unit = self.choice.kernel, self.scaling.unit
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
