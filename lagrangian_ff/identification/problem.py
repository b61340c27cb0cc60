"""A semi-parametric Gaussian-process problem (44): samples, kernel, noise, unit and basis."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lagrangian_ff.arrays import Flags, Floats, Ints
from lagrangian_ff.effects import Inputs
from lagrangian_ff.identification.basis import Basis, Term, shares
from lagrangian_ff.identification.samples import Samples, evenly
from lagrangian_ff.identification.spec import Spec
from lagrangian_ff.kernels import CoupledKernel, Kernel, States
from lagrangian_ff.kernels.dense import gram_of, together

NOISE_START = 1e-2
"""Variance of the noise over the kernel's, before anything is chosen."""
STUCK_NOISE = 1e6
"""Variance of the torque of a joint at rest, relative to its noise: it stays anywhere within static
friction, some thirty times the noise, for as long as the joint rests, which may be 1000 samples."""


@dataclass(frozen=True)
class Scaling:
    """The normalisation of torques for the kernel.

    Attributes:
        unit: (N,) N·m that count as one; undone on the way out.
        noise: (N,) relative standard deviation of the noise between joints, in those units.
    """

    unit: Floats
    noise: Floats

    @classmethod
    def of(cls, tau: Floats, per_joint: bool = True, weight: Floats | None = None) -> "Scaling":
        """Return the scaling by each joint's own spread, or by the largest of them for all.

        With one unit for all joints the predicted torques still derive from one Lagrangian, and
        the noise is taken in proportion to each joint's spread instead.

        Args:
            tau: (S, N) N·m.  per_joint: whether each joint has its own unit.
            weight: (S, N) of each torque; None is 1.
        """
        middle = np.average(tau, axis=0, weights=weight)
        spread = np.sqrt(np.average((tau - middle) ** 2, axis=0, weights=weight))
        largest = spread.max(initial=0.0) or 1.0
        spread = np.where(spread > 1e-9 * largest, spread, largest)
        if per_joint:
            return cls(spread, np.ones_like(spread))
        return cls(np.full_like(spread, largest), spread / largest)

    @property
    def spread(self) -> Floats:
        """Return (N,) N·m, the spread of each joint's torque."""
        return self.unit * self.noise


@dataclass(frozen=True)
class Prior:
    """The assumptions of (44) about torques before any was measured.

    Attributes:
        kernel: of the rigid-body torques, in units of `scaling`, with its hyperparameters.
        noise: (N,) variance of each torque in the kernel's units, γ M of (42), before
            `scaling.noise`, whose square multiplies it.
        scaling: of the torques.
        basis: the effects' terms with their shapes.
    """

    kernel: Kernel
    noise: Floats
    scaling: Scaling
    basis: Basis

    def noisier(self, factor: float) -> "Prior":
        """Return the prior with the noise variance multiplied by a factor."""
        return replace(self, noise=self.noise * factor)


@dataclass(frozen=True)
class Nuisance:
    """Columns in one joint's torque that are no effect of the model.

    Attributes:
        joint: index of the joint.  columns: (S, K) N·m.
        others: further joints, with the factor of the columns in their torques.
    """

    joint: int
    columns: Floats
    others: Mapping[int, float] = field(default_factory=dict)


@dataclass(frozen=True)
class Rows:
    """The torques of n joints that are solved together: S n rows, sample major, normalised.

    Attributes:
        states: (S, N), of all joints.
        columns: (S, B) the basis, each column in the torque of its joint, N·m.
        on: (B, n) the factor of each column in the normalised torque of each of the n joints.
        target: (S n,) the torques y.  noise: (S n,) variance of each torque.
        stuck: (S n,) those of joints at rest, which say nothing of the noise.
    """

    states: States
    columns: Floats
    on: Floats
    target: Floats
    noise: Floats
    stuck: Flags

    def of(self, samples: Ints) -> Ints:
        """Return (R n,) the rows of these samples."""
        return rows_of(samples, len(self.target) // len(self.states))

    def design(self, samples: "Ints | slice" = slice(None)) -> Floats:
        """Return Φ of these samples, (R n, B)."""
        columns = self.columns[samples]
        out = columns[:, None, :] * self.on.T
        return np.asarray(out.reshape(out.shape[0] * out.shape[1], out.shape[2]))


@dataclass(frozen=True)
class Problem:
    """Problem (44), ready to be solved.

    Attributes:
        samples: to learn from.  prior: kernel, noise, scaling and basis.
        nuisance: columns that are fitted besides.
        change: an interval of time, in s, in which another Lagrangian is added to the arm's own, as
            with a load at the hand, and its variance in parts of the first; None has none.
    """

    samples: Samples
    prior: Prior
    nuisance: tuple[Nuisance, ...] = ()
    change: tuple[float, float, float] | None = None

    @classmethod
    def started(cls, spec: Spec, samples: Samples, scaling: Scaling) -> "Problem":
        """Return a problem of a spec with the initial hyperparameters of every search."""
        joints = samples.x.joints
        kernel = spec.kernel.start(samples.states)
        if spec.sliding:
            slides = np.isin(np.arange(joints), spec.sliding)
            kernel = kernel.replace(prismatic=slides.astype(np.float64))
        if spec.weightless:
            kernel = kernel.without_gravity()
        shapes = {e.name: {s.name: s.start for s in e.shapes} for e in spec.effects}
        terms = (Term(e, joint, shapes[e.name]) for joint in range(joints) for e in spec.effects)
        problem = cls(samples, Prior(kernel, np.ones(joints), scaling, Basis(tuple(terms))))
        return problem.with_relative_noise(np.array([NOISE_START]))

    @property
    def kernel(self) -> Kernel:
        """Return the kernel of the prior."""
        return self.prior.kernel

    @property
    def basis(self) -> Basis:
        """Return the basis of the prior."""
        return self.prior.basis

    @property
    def noise(self) -> Floats:
        """Return (N,) the noise of the prior."""
        return self.prior.noise

    @property
    def unit(self) -> Floats:
        """Return (N,) N·m that count as one."""
        return self.prior.scaling.unit

    @property
    def variances(self) -> Floats:
        """Return (N,) variance of the noise of each joint's torque, in units of `unit`."""
        return self.prior.noise * self.prior.scaling.noise**2

    @property
    def together(self) -> list[tuple[int, ...]]:
        """Return the joints that are solved together, group by group."""
        return together(self.kernel, self.samples.x.joints)

    def of(self, samples: Samples) -> "Problem":
        """Return the problem with the same assumptions of other samples."""
        return replace(self, samples=samples)

    def having(self, **changes: Any) -> "Problem":
        """Return the problem with another `kernel`, `noise`, `scaling` or `basis`."""
        return replace(self, prior=replace(self.prior, **changes))

    def take(self, index: Ints) -> "Problem":
        """Return the problem of some of the samples."""
        nuisance = tuple(replace(one, columns=one.columns[index]) for one in self.nuisance)
        return replace(self, samples=self.samples.take(index), nuisance=nuisance)

    def thinned(self, count: int) -> "Problem":
        """Return the problem of at most this many samples, evenly spread."""
        return self.take(evenly(len(self.samples), count))

    def noisier(self, factor: float) -> "Problem":
        """Return the problem with the noise variance multiplied by a factor."""
        return replace(self, prior=self.prior.noisier(factor))

    def weighted(self, weight: Floats | None) -> "Problem":
        """Return the problem with other IRLS weights (S, N)."""
        return replace(self, samples=replace(self.samples, weight=weight))

    def with_relative_noise(self, relative: Floats) -> "Problem":
        """Return the problem with the noise set relative to the kernel's mean prior variance.

        Args:
            relative: (N,) or (1,) ratio of noise variance to prior variance.
        """
        prior = self.kernel.variance(self.samples.states).mean(axis=0)
        if isinstance(self.kernel, CoupledKernel):
            prior = np.full_like(prior, prior.mean())
        prior = np.where(prior > 0.0, prior, 1.0)
        return self.having(noise=np.broadcast_to(relative, prior.shape) * prior)

    def gram(self, joints: tuple[int, ...]) -> Floats:
        """Return the Gram matrix (S n, S n) of joints that are solved together.

        It is new and C-contiguous; only the lower triangle is written.
        """
        gram = gram_of(self.kernel, self.samples.states, joints)
        if self.change is None:
            return gram
        rows = np.flatnonzero(np.repeat(within(self.change, self.samples.x), len(joints)))
        with np.errstate(all="ignore"):  # above the diagonal lies what memory held before
            if len(rows) and rows[-1] - rows[0] == len(rows) - 1:
                part = slice(rows[0], rows[-1] + 1)
                gram[part, part] *= 1.0 + self.change[2]
            elif len(rows):
                gram[np.ix_(rows, rows)] *= 1.0 + self.change[2]
        return gram

    def second(self) -> Floats | None:
        """Return m, (S N,), of the Gram matrix K + K ∘ m mᵀ with a change; None without one."""
        if self.change is None:
            return None
        x = self.samples.x
        return np.repeat(np.sqrt(self.change[2]) * within(self.change, x), x.joints)

    def rows(self, joints: tuple[int, ...]) -> Rows:
        """Return the normalised torques and basis of joints that are solved together."""
        x, columns = self.samples.x, list(joints)
        part = self.basis.of_joints(joints)
        held, on = [part.columns(x)], [part.on(x.joints)]
        for one in self.nuisance:
            if one.joint in joints:
                held.append(one.columns)
                factor = shares(x.joints, one.joint, one.others)
                on.append(np.tile(factor, (one.columns.shape[1], 1)))
        stuck = x.rest[:, columns].ravel()
        noise = np.tile(self.variances[columns], len(x)) * np.where(stuck, STUCK_NOISE, 1.0)
        if self.samples.weight is not None:
            noise = noise / self.samples.weight[:, columns].ravel()
        target = (self.samples.tau[:, columns] / self.unit[columns]).ravel()
        factors = np.concatenate(on)[:, columns] / self.unit[columns]
        return Rows(self.samples.states, np.column_stack(held), factors, target, noise, stuck)


def rows_of(samples: Ints, width: int) -> Ints:
    """Return (R n,) the rows of some samples in a system of n joints."""
    return np.asarray((samples[:, None] * width + np.arange(width)).ravel(), dtype=np.int64)


def within(change: tuple[float, float, float], x: Inputs) -> NDArray[np.bool_]:
    """Return (S,) which samples lie in the interval of a change."""
    since, until, _ = change
    return np.asarray((x.time >= since) & (x.time < until))
