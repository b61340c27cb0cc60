"""What a kernel on torques is: the two shapes it comes in, and nothing else.

A *coupled* kernel is matrix valued, eq. (22): K(x, u) is N × N and one system of M N equations is
solved. An *independent* kernel is diagonal, eqs. (30), (35), (52): every joint has its own scalar
kernel and N systems of M equations are solved.
"""

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

import numpy as np
from numpy.typing import NDArray

from lagrangian_ff.kernels.states import States

if TYPE_CHECKING:
    from lagrangian_ff.kernels.mechanism import Mechanism

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Hyperparameter:
    """One number of a kernel that data choose.

    Attributes:
        name: as in the paper.
        unit: its physical unit.
        meaning: one sentence for people.
        low, high: the range that is searched, on a logarithmic scale, as multiples of the start.
    """

    name: str
    unit: str
    meaning: str
    low: float
    high: float


class Kernel(ABC):
    """A positive semi-definite kernel on joint torques."""

    name: ClassVar[str]
    meaning: ClassVar[str]
    searched: ClassVar[tuple[Hyperparameter, ...]] = ()
    """The hyperparameters that a simplex search chooses by evidence or validation."""
    further: ClassVar[tuple[Hyperparameter, ...]] = ()
    """What the other numbers are; the range of these is not searched."""
    free: ClassVar[bool] = False
    """Whether gravity may be any smooth function of the positions, and hold a spring's torque."""
    mechanism: ClassVar["Mechanism | None"] = None
    """What is known of the mechanism; None where the kernel knows nothing of it."""

    @classmethod
    @abstractmethod
    def start(cls, x: States) -> "Kernel":
        """The kernel with the starting values that suit these states, nothing searched yet."""

    @property
    @abstractmethod
    def hyperparameters(self) -> Mapping[str, Floats]:
        """Every number the kernel needs, by name: (1,) common to all joints, or (N,)."""

    @abstractmethod
    def replace(self, **hyperparameters: Floats) -> "Kernel":
        """The same kernel with some hyperparameters changed."""

    @abstractmethod
    def apply(self, x: States, u: States, a: Floats) -> Floats:
        """(M, N) torques Σ_j K(x_i, u_j) a_j for coefficients a (M_u, N), as in (32), (33)."""

    def learned(self, u: States, a: Floats) -> "Learned":
        """The torques Σ_j K(·, u_j) a_j, in the form that is cheapest to ask again and again."""
        return Sum(self, u, a)

    @abstractmethod
    def variance(self, x: States) -> Floats:
        """(M, N) the diagonal K_nn(x_i, x_i): the prior variance of each torque."""


class Learned(ABC):
    """Torques that were learned: a function of the state alone."""

    @abstractmethod
    def torque(self, x: States) -> Floats:
        """(M, N) torques in the kernel's units."""


@dataclass(frozen=True)
class Sum(Learned):
    """Torques as a sum over the states that they were learned from.

    Attributes:
        kernel: of the torques.  u: (M_u, N) states.  a: (M_u, N) coefficients.
    """

    kernel: Kernel
    u: States
    a: Floats

    def torque(self, x: States) -> Floats:
        """See `Learned.torque`."""
        return self.kernel.apply(x, self.u, self.a)


class CoupledKernel(Kernel):
    """A matrix-valued kernel: the torques of all joints inform each other."""

    @abstractmethod
    def gram(self, x: States) -> Floats:
        """(M N, M N) Gram matrix, sample major; only its lower triangle of blocks is written."""

    @abstractmethod
    def cross(self, x: States, u: States) -> Floats:
        """(M_x N, M_u N) kernel between two sets of states, sample major."""


class LagrangianKernel(CoupledKernel):
    """A coupled kernel whose torques derive from one Lagrangian, which it can tell.

    A torque tells its Lagrangian up to a constant and a total time derivative; what comes out is
    the member of least norm.
    """

    quadratic: ClassVar[bool]
    """Whether kinetic energy is quadratic in velocity, so that the mass matrix is that of q."""

    @abstractmethod
    def lagrangian(self, x: States, u: States, a: Floats) -> Floats:
        """(M,) L(q, qd) = Σ_j T_u k_L(x_i, u_j)·a_j for coefficients a (M_u, N), eq. (31)."""

    @abstractmethod
    def momentum(self, x: States, u: States, a: Floats) -> Floats:
        """(M, N) its derivative ∂L/∂qd."""


class DifferentiableKernel(CoupledKernel):
    """A coupled kernel whose derivatives by its hyperparameters are known."""

    differentiable: ClassVar[tuple[str, ...]]
    """The hyperparameters, all positive, that the evidence can be climbed in."""
    variances: ClassVar[tuple[str, ...]] = ()
    """Those of them that are the variance of a torque which no arm has many times as large."""

    @abstractmethod
    def contract(self, x: States, weights: Floats, vector: Floats) -> Mapping[str, "Contracted"]:
        """What the derivative K' of the Gram matrix by each hyperparameter does, by name.

        Args:
            x: (M, N) states.
            weights: (M N, M N) symmetric W, C-contiguous, of which the lower triangle is read.
            vector: (M N,) a.
        """


@dataclass(frozen=True)
class Contracted:
    """The derivatives of a Gram matrix by K numbers of one name, each seen through two eyes.

    Attributes:
        total: (K,) Σ_ab W_ab K'_ab.
        product: (K, M N) K' a.
    """

    total: Floats
    product: Floats


class IndependentKernel(Kernel):
    """A diagonal kernel: one scalar kernel a joint."""

    per_joint: ClassVar[bool] = True
    """Whether each joint chooses its own hyperparameters, as in (35), or all share, as in (30)."""

    @abstractmethod
    def cross(self, x: States, u: States, joint: int) -> Floats:
        """(M_x, M_u) scalar kernel of one joint between two sets of states."""

    def gram(self, x: States, joint: int) -> Floats:
        """(M, M) Gram matrix of one joint."""
        return self.cross(x, x, joint)

    def apply(self, x: States, u: States, a: Floats) -> Floats:
        """See `Kernel.apply`; in chunks, so that memory stays bounded."""
        out = np.empty((len(x), a.shape[1]))
        rows = max(1, CHUNK_ENTRIES // max(1, len(u)))
        for first in range(0, len(x), rows):
            part = slice(first, first + rows)
            states = x.take(part)
            for joint in range(a.shape[1]):
                out[part, joint] = self.cross(states, u, joint) @ a[:, joint]
        return out


CHUNK_ENTRIES = 4_000_000
"""Kernel values held at once while a kernel is applied: 32 MB."""


def of_joint(value: Floats, joint: int) -> float:
    """The value of one joint of a hyperparameter that is common, (1,), or per joint, (N,)."""
    return float(value[joint] if value.shape[0] > 1 else value[0])


def largest(values: Floats) -> float:
    """The largest magnitude, or 1 where nothing moves: what the paper normalises rates by."""
    peak = float(np.max(np.abs(values), initial=0.0))
    return peak if peak > 0.0 else 1.0
