"""The kernel of a mechanism with loops: Gᵀ K_T G, eq. (48).

The torque of the active joints is that of the tree's joints projected by G = ∂q_tr/∂q_a, so that a
kernel K_T of the tree's torques is one of theirs. The states of the tree follow from theirs:
qd_tr = G qd, qdd_tr = G qdd + dG/dt qd.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, ClassVar, TypeVar

import numpy as np
from numpy.typing import NDArray

from lagrangian_ff.kernels.base import Contracted, CoupledKernel, DifferentiableKernel, Kernel
from lagrangian_ff.kernels.dense import dense_cross, dense_gram
from lagrangian_ff.kernels.states import States

if TYPE_CHECKING:
    from lagrangian_ff.kernels.constrained.linkage import Linkage

Floats = NDArray[np.float64]
Self = TypeVar("Self", bound="Closed")

DIAGONAL_SAMPLES = 16
"""Samples whose blocks are formed at once where only those on the diagonal are wanted."""


@dataclass(frozen=True)
class Closed(CoupledKernel):
    """A kernel of the tree, projected onto the active joints.

    Attributes:
        kernel: K_T, of the family.
    """

    kernel: Kernel

    mechanism: ClassVar["Linkage"]
    family: ClassVar[type[Kernel]]

    @classmethod
    def start(cls: type[Self], x: States) -> Self:
        """As the family starts on the tree's states."""
        return cls(cls.family.start(cls.mechanism.tree(x)[0]))

    @property
    def hyperparameters(self) -> Mapping[str, Floats]:
        """See `Kernel.hyperparameters`."""
        return self.kernel.hyperparameters

    def replace(self: Self, **hyperparameters: Floats) -> Self:
        """See `Kernel.replace`."""
        return replace(self, kernel=self.kernel.replace(**hyperparameters))

    def gram(self, x: States) -> Floats:
        """See `CoupledKernel.gram`."""
        tree, g = self.mechanism.tree(x)
        with np.errstate(all="ignore"):  # above the diagonal stands what memory held
            return _projected(dense_gram(self.kernel, tree), g, g)

    def cross(self, x: States, u: States) -> Floats:
        """See `CoupledKernel.cross`."""
        (at, g), (of, h) = self.mechanism.tree(x), self.mechanism.tree(u)
        return _projected(dense_cross(self.kernel, at, of), g, h)

    def apply(self, x: States, u: States, a: Floats) -> Floats:
        """See `Kernel.apply`."""
        (at, g), (of, h) = self.mechanism.tree(x), self.mechanism.tree(u)
        torque = self.kernel.apply(at, of, np.einsum("mtn,mn->mt", h, a))
        return np.asarray(np.einsum("mtn,mt->mn", g, torque))

    def variance(self, x: States) -> Floats:
        """See `Kernel.variance`."""
        out = np.empty_like(x.q)
        for first in range(0, len(x), DIAGONAL_SAMPLES):
            part = slice(first, first + DIAGONAL_SAMPLES)
            here = x.take(part)
            blocks = self.cross(here, here).reshape(len(here), x.joints, len(here), x.joints)
            out[part] = np.einsum("mnmn->mn", blocks)
        return out


class ClosedDifferentiable(Closed, DifferentiableKernel):
    """The same of a kernel that climbs its evidence."""

    def contract(self, x: States, weights: Floats, vector: Floats) -> Mapping[str, Contracted]:
        """See `DifferentiableKernel.contract`: with G as part of weights and vector."""
        assert isinstance(self.kernel, DifferentiableKernel)
        tree, g = self.mechanism.tree(x)
        lower = np.tril(weights)
        symmetric = lower + np.tril(lower, -1).T
        lifted = _projected(symmetric, g.transpose(0, 2, 1), g.transpose(0, 2, 1))
        moved = np.einsum("mtn,mn->mt", g, vector.reshape(len(x), x.joints))
        found = {}
        for name, one in self.kernel.contract(tree, lifted, moved.ravel()).items():
            product = one.product.reshape(-1, len(x), tree.joints)
            projected = np.einsum("mtn,kmt->kmn", g, product).reshape(len(product), -1)
            found[name] = Contracted(one.total, projected)
        return found


def _projected(matrix: Floats, g: Floats, h: Floats) -> Floats:
    """(M N, K L) gᵀ matrix h, block by block, for a matrix (M T, K S), g (M, T, N), h (K, S, L)."""
    (m, t, n), (k, s, _) = g.shape, h.shape
    left = g.transpose(0, 2, 1) @ matrix.reshape(m, t, k * s)
    right = left.reshape(m * n, k, s).transpose(1, 0, 2) @ h
    return np.ascontiguousarray(right.transpose(1, 0, 2)).reshape(m * n, -1)


def closed(linkage: "Linkage", family: type[Kernel]) -> type[Kernel]:
    """The family of kernels of a linkage, for a family of kernels of its tree."""
    differentiable = issubclass(family, DifferentiableKernel)
    words: dict[str, Any] = {
        "mechanism": linkage,
        "family": family,
        "free": family.free,
        "name": family.name,
        "meaning": f"the loops of {linkage.name} closed: {family.meaning}",
        "searched": family.searched,
    }
    if issubclass(family, DifferentiableKernel):
        words["differentiable"] = family.differentiable
    base = ClosedDifferentiable if differentiable else Closed
    return type(f"Closed{family.__name__}", (base,), words)
