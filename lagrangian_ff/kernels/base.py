"""The interface of kernels on torques, and of mechanisms of which something is known.

A *coupled* kernel is matrix valued, eq. (22): K(x, u) is N × N and one system of M N equations is
solved. An *independent* kernel is diagonal, eqs. (30), (35), (52): every joint has its own scalar
kernel and N systems of M equations are solved.

A plain kernel is a frozen dataclass whose fields are its hyperparameters, and one method, `cross`.
All else has a default; override it where something faster is known.
"""

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass, fields, replace
from operator import attrgetter
from typing import Any, ClassVar, TypeVar

import numpy as np

from lagrangian_ff.arrays import Floats
from lagrangian_ff.kernels.states import States

Self = TypeVar("Self", bound="Kernel")
Outer = TypeVar("Outer", bound="MechanismKernel")

CHUNK_ENTRIES = 4_000_000
"""Kernel values held at once while a kernel is applied: 32 MB."""
DIAGONAL_SAMPLES = 16
"""Samples whose blocks are formed at once where only the diagonal is needed."""


@dataclass(frozen=True)
class Hyperparameter:
    """A hyperparameter that is learned from data.

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


@dataclass(frozen=True)
class Kernel(ABC):
    """A positive semi-definite kernel on joint torques; its fields are its hyperparameters."""

    name: ClassVar[str]
    meaning: ClassVar[str]
    searched: ClassVar[tuple[Hyperparameter, ...]] = ()
    """The hyperparameters that a simplex search chooses by evidence or validation."""
    further: ClassVar[tuple[Hyperparameter, ...]] = ()
    """The other hyperparameters; their range is not searched."""
    free: ClassVar[bool] = False
    """True if gravity may be any smooth function of position, and so include a spring's torque."""
    separates: ClassVar[bool] = False
    """True if gravity is a part of its own, which `without_gravity` leaves out."""
    coupled: ClassVar[bool]
    """True if the torques of all joints are learned together."""
    per_joint: ClassVar[bool] = False
    """True if each joint has its own hyperparameters, as in (35); else all share, as in (30)."""
    has_lagrangian: ClassVar[bool] = False
    """True if it is a `LagrangianKernel`."""
    differentiable: ClassVar[tuple[str, ...]] = ()
    """The hyperparameters, all positive, by which `DifferentiableKernel` has derivatives."""
    mechanism: ClassVar["Mechanism | None"] = None
    """The known part of the mechanism; None for a kernel that needs no such knowledge."""

    @classmethod
    def start(cls: type[Self], x: States) -> Self:
        """Return the kernel with starting values for these states: by default 1, for all joints."""
        return cls(**{one.name: np.ones(1) for one in fields(cls)})

    @property
    def family(self) -> "Family":
        """Return what `start` was called on."""
        return type(self)

    @property
    def hyperparameters(self) -> Mapping[str, Floats]:
        """Return every hyperparameter by name: (1,) common to all joints, or (N,)."""
        return {one.name: getattr(self, one.name) for one in fields(self)}

    def replace(self: Self, **hyperparameters: Floats) -> Self:
        """Return the kernel with some hyperparameters changed."""
        return replace(self, **hyperparameters)

    def without_gravity(self: Self) -> Self:
        """Return the kernel without potential energy, if it separates that from the rest.

        The torque is then exactly zero at rest. Other kernels stay as they are: `separates`.
        """
        return self

    @abstractmethod
    def apply(self, x: States, u: States, a: Floats) -> Floats:
        """Return (M, N) torques Σ_j K(x_i, u_j) a_j for coefficients a (M_u, N), (32), (33)."""

    def learned(self, u: States, a: Floats) -> "Learned":
        """Return the torques Σ_j K(·, u_j) a_j, in the form that is cheapest to evaluate."""
        return Sum(self, u, a)

    @abstractmethod
    def variance(self, x: States) -> Floats:
        """Return (M, N) the diagonal K_nn(x_i, x_i): the prior variance of each torque."""


class Learned(ABC):
    """Torques that were learned: a function of the state alone."""

    @abstractmethod
    def torque(self, x: States) -> Floats:
        """Return (M, N) torques in the kernel's units."""


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
        return self.kernel.apply(x, self.u, self.a)


class CoupledKernel(Kernel):
    """A matrix-valued kernel: the torques of all joints are learned together."""

    coupled = True

    @abstractmethod
    def cross(self, x: States, u: States) -> Floats:
        """Return the kernel between two sets of states, (M_x N, M_u N), sample major."""

    def gram(self, x: States) -> Floats:
        """Return the Gram matrix, (M N, M N), sample major; its upper blocks need not be set."""
        return np.ascontiguousarray(self.cross(x, x))

    def apply(self, x: States, u: States, a: Floats) -> Floats:
        out = np.empty((len(x), x.joints))
        for part in chunks(len(x), CHUNK_ENTRIES // max(1, a.size * x.joints)):
            out[part] = (self.cross(x.take(part), u) @ a.ravel()).reshape(-1, x.joints)
        return out

    def variance(self, x: States) -> Floats:
        out = np.empty_like(x.q)
        for part in chunks(len(x), DIAGONAL_SAMPLES):
            here = x.take(part)
            blocks = self.cross(here, here).reshape(len(here), x.joints, len(here), x.joints)
            out[part] = np.einsum("mnmn->mn", blocks)
        return out


class LagrangianKernel(CoupledKernel):
    """A coupled kernel whose torques derive from one Lagrangian that can be recovered.

    Torques determine their Lagrangian up to a constant and a total time derivative; the methods
    return the one of least norm.
    """

    has_lagrangian = True
    quadratic: ClassVar[bool]
    """True if kinetic energy is quadratic in velocity, so that the mass matrix is that of q."""

    @abstractmethod
    def lagrangian(self, x: States, u: States, a: Floats) -> Floats:
        """Return (M,) L(q, qd) = Σ_j T_u k_L(x_i, u_j)·a_j for coefficients a (M_u, N), (31)."""

    @abstractmethod
    def momentum(self, x: States, u: States, a: Floats) -> Floats:
        """Return (M, N) its derivative ∂L/∂qd."""


class DifferentiableKernel(CoupledKernel):
    """A coupled kernel whose derivatives by its `differentiable` hyperparameters are known."""

    variances: ClassVar[tuple[str, ...]] = ()
    """The hyperparameters that are variances of a torque, unlikely to be many times its square."""

    @abstractmethod
    def contract(self, x: States, weights: Floats, vector: Floats) -> Mapping[str, "Contracted"]:
        """Return contractions of the Gram matrix's derivative K' by each hyperparameter, by name.

        Args:
            x: (M, N) states.
            weights: (M N, M N) symmetric W, C-contiguous, of which the lower triangle is read.
            vector: (M N,) a.
        """


@dataclass(frozen=True)
class Contracted:
    """Contractions of a Gram matrix's derivatives K' by K hyperparameters of one name.

    Attributes:
        total: (K,) Σ_ab W_ab K'_ab.
        product: (K, M N) K' a.
    """

    total: Floats
    product: Floats


class IndependentKernel(Kernel):
    """A diagonal kernel: one scalar kernel a joint."""

    coupled = False
    per_joint = True

    @abstractmethod
    def cross(self, x: States, u: States, joint: int) -> Floats:
        """Return (M_x, M_u) the scalar kernel of one joint between two sets of states."""

    def gram(self, x: States, joint: int) -> Floats:
        """Return (M, M) the Gram matrix of one joint."""
        return self.cross(x, x, joint)

    def apply(self, x: States, u: States, a: Floats) -> Floats:
        out = np.empty((len(x), a.shape[1]))
        for part in chunks(len(x), CHUNK_ENTRIES // max(1, len(u))):
            states = x.take(part)
            for joint in range(a.shape[1]):
                out[part, joint] = self.cross(states, u, joint) @ a[:, joint]
        return out

    def variance(self, x: States) -> Floats:
        out = np.empty_like(x.q)
        for part in chunks(len(x), DIAGONAL_SAMPLES):
            here = x.take(part)
            for joint in range(x.joints):
                out[part, joint] = np.diagonal(self.cross(here, here, joint))
        return out


class Mechanism(ABC):
    """Makes kernels of a mechanism from kernels that know nothing of it."""

    @abstractmethod
    def of_joints(self, joints: tuple[str, ...], source: str) -> "Mechanism":
        """Return the mechanism with its coordinates in the order of a recording.

        Args:
            joints: N names.  source: where they are from, for the message.

        Raises:
            ModelError: the mechanism lacks one; names the joints of both.
        """

    @property
    def base_to_tool(self) -> tuple[str, ...]:
        """Return the names of its joints from base to tool; empty if it does not know them."""
        return ()

    def without_gravity(self) -> "Mechanism":
        """Return the mechanism where nothing has weight; by default it has none of its own."""
        return self

    @abstractmethod
    def around(self, family: "Family") -> "MechanismFamily":
        """Return the kernels of this mechanism whose unknown part is learned by a family.

        Raises:
            ModelError: the family does not fit it.
        """

    @abstractmethod
    def record(self) -> dict[str, object]:
        """Return what is known, for people; as JSON holds it."""

    @abstractmethod
    def stored(self) -> dict[str, object]:
        """Return what a model file keeps of it; as JSON holds it, its class under `kind`."""


@dataclass(frozen=True)
class MechanismFamily(ABC):
    """The kernels of a mechanism; it has the attributes of a class of kernels, see `Kernel`.

    Attributes:
        mechanism: the known part.
        inner: the kernels that learn the unknown part.
        meaning: one sentence for people.
        searched, differentiable: hyperparameters of both.
    """

    mechanism: Mechanism
    inner: "Family"
    meaning: str
    searched: tuple[Hyperparameter, ...]
    differentiable: tuple[str, ...]

    further: ClassVar[tuple[Hyperparameter, ...]] = ()
    coupled: ClassVar[bool] = True
    per_joint: ClassVar[bool] = False

    name: ClassVar[Any] = property(attrgetter("inner.name"))
    free: ClassVar[Any] = property(attrgetter("inner.free"))
    separates: ClassVar[Any] = property(attrgetter("inner.separates"))
    has_lagrangian: ClassVar[Any] = property(attrgetter("inner.has_lagrangian"))

    @abstractmethod
    def start(self, x: States) -> "MechanismKernel":
        """Return the kernel with starting values for these states."""


Family = type[Kernel] | MechanismFamily
"""Kernels that differ in their hyperparameters alone."""


@dataclass(frozen=True)
class MechanismKernel(CoupledKernel):
    """A kernel of a mechanism; further fields of a subclass are hyperparameters.

    Attributes:
        of: the family that made it.
        kernel: the kernel that learns the unknown part.
    """

    of: MechanismFamily
    kernel: Kernel

    name: ClassVar[Any] = property(attrgetter("of.name"))
    meaning: ClassVar[Any] = property(attrgetter("of.meaning"))
    searched: ClassVar[Any] = property(attrgetter("of.searched"))
    free: ClassVar[Any] = property(attrgetter("of.free"))
    separates: ClassVar[Any] = property(attrgetter("of.separates"))
    has_lagrangian: ClassVar[Any] = property(attrgetter("of.has_lagrangian"))
    differentiable: ClassVar[Any] = property(attrgetter("of.differentiable"))
    mechanism: ClassVar[Any] = property(attrgetter("of.mechanism"))

    @property
    def family(self) -> Family:
        return self.of

    @property
    def hyperparameters(self) -> Mapping[str, Floats]:
        own = {one.name: getattr(self, one.name) for one in fields(self)[2:]}
        return {**own, **self.kernel.hyperparameters}

    def without_gravity(self: Outer) -> Outer:
        return replace(self, kernel=self.kernel.without_gravity())

    def replace(self: Outer, **hyperparameters: Floats) -> Outer:
        mine = {one.name for one in fields(self)}.intersection(hyperparameters)
        own: dict[str, Any] = {name: hyperparameters.pop(name) for name in mine}
        return replace(self, kernel=self.kernel.replace(**hyperparameters), **own)


def chunks(count: int, size: int) -> list[slice]:
    """Return slices of `size` samples each, at least 1, that cover `count` samples."""
    return [slice(first, first + max(1, size)) for first in range(0, count, max(1, size))]


def symmetric(lower: Floats) -> Floats:
    """Return the symmetric matrix whose lower triangle is given."""
    kept = np.tril(lower)
    return np.asarray(kept + np.tril(kept, -1).T)


def of_joint(value: Floats, joint: int) -> float:
    """Return a joint's value of a hyperparameter that is common, (1,), or per joint, (N,)."""
    return float(value[joint] if value.shape[0] > 1 else value[0])


def largest(values: Floats) -> float:
    """Return the largest magnitude, or 1 if all are 0: what the paper normalises rates by."""
    peak = float(np.max(np.abs(values), initial=0.0))
    return peak if peak > 0.0 else 1.0
