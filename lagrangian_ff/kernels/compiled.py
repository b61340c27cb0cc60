"""Coupled kernels whose loops over pairs of states are compiled."""

from abc import abstractmethod
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from lagrangian_ff.kernels.base import CoupledKernel, Learned
from lagrangian_ff.kernels.states import States

Floats = NDArray[np.float64]
Prepared = tuple[Floats, Floats, Floats, Floats, Floats]


def contiguous(x: States) -> tuple[Floats, Floats, Floats]:
    """q, qd, qdd in the one layout for which loops are compiled: each other one would cost anew."""
    return np.ascontiguousarray(x.q), np.ascontiguousarray(x.qd), np.ascontiguousarray(x.qdd)


def prepared(x: States) -> Prepared:
    """What the loops read of states: q, qd, qdd, and the sines and cosines of q."""
    q, qd, qdd = contiguous(x)
    return q, qd, qdd, np.sin(q), np.cos(q)


class CompiledKernel(CoupledKernel):
    """A coupled kernel made of the loops of one module.

    Attributes:
        loops: a module with `gram_lower`, `cross_blocks`, `apply_blocks` and `variances`.
    """

    loops: ClassVar[Any]

    @abstractmethod
    def _weights(self, joints: int) -> tuple[Any, ...]:
        """The numbers that the loops take after the states."""

    def gram(self, x: States) -> Floats:
        """See `CoupledKernel.gram`."""
        size = len(x) * x.joints
        out = np.empty((size, size))
        self.loops.gram_lower(prepared(x), *self._weights(x.joints), out)
        return out

    def cross(self, x: States, u: States) -> Floats:
        """See `CoupledKernel.cross`."""
        out = np.empty((len(x), x.joints, len(u), x.joints))
        self.loops.cross_blocks(prepared(x), prepared(u), *self._weights(x.joints), out)
        return out.reshape(len(x) * x.joints, len(u) * x.joints)

    def apply(self, x: States, u: States, a: Floats) -> Floats:
        """See `Kernel.apply`; no block is formed."""
        return self.learned(u, a).torque(x)

    def learned(self, u: States, a: Floats) -> Learned:
        """See `Kernel.learned`."""
        return _Prepared(self, prepared(u), self._weights(u.joints), np.ascontiguousarray(a))

    def variance(self, x: States) -> Floats:
        """See `Kernel.variance`."""
        out = np.empty((len(x), x.joints))
        self.loops.variances(prepared(x), *self._weights(x.joints), out)
        return out


@dataclass(frozen=True)
class _Prepared(Learned):
    """A sum over states of which sines and cosines are known."""

    kernel: CompiledKernel
    u: Prepared
    weights: tuple[Any, ...]
    a: Floats

    def torque(self, x: States) -> Floats:
        """See `Learned.torque`."""
        out = np.empty(x.q.shape)
        self.kernel.loops.apply_blocks(prepared(x), self.u, *self.weights, self.a, out)
        return out
