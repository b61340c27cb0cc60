"""The kernel of a serial arm: quadratic in velocity, gravity apart, joints in their order."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from lagrangian_ff.kernels import chained
from lagrangian_ff.kernels.base import CoupledKernel, Hyperparameter, largest
from lagrangian_ff.kernels.states import States

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Chain(CoupledKernel):
    """One Lagrangian, a sum over the prefixes of a serial chain; see `chained`.

    It holds the rigid-body dynamics of every serial arm with revolute joints, and little else:
    joints are to be given from the base to the tool.

    Attributes:
        inertia: (N,) Λ, s²/rad² in the kernel's units: how much a joint's motion weighs.
        potential: (1,) λ, the weight of gravity against that of inertia.
        wave: (1,) ω in (0, 1], how much a Lagrangian changes with the joint angles.
        rotor: (1,) ρ, the weight of rotors that turn with their own joint only.
    """

    inertia: Floats
    potential: Floats
    wave: Floats
    rotor: Floats

    name: ClassVar[str] = "chain"
    meaning: ClassVar[str] = "one Lagrangian of a serial arm: quadratic in velocity, gravity apart"
    searched: ClassVar[tuple[Hyperparameter, ...]] = (
        Hyperparameter("inertia", "s²/rad²", "Λ: weight of the joints' motion", 1e-3, 1e3),
        Hyperparameter("potential", "1", "λ: weight of gravity against inertia", 1e-3, 1e3),
        Hyperparameter("wave", "1", "ω: how much the Lagrangian changes with angles", 1e-3, 10.0),
    )

    @classmethod
    def start(cls, x: States) -> "Chain":
        """Every joint weighs as its velocity asks for; gravity as much as inertia."""
        return cls(
            inertia=np.array([1.0 / largest(x.qd[:, n]) ** 2 for n in range(x.joints)]),
            potential=np.array([1.0]),
            wave=np.array([0.1]),
            rotor=np.array([1.0]),
        )

    @property
    def hyperparameters(self) -> Mapping[str, Floats]:
        """See `Kernel.hyperparameters`."""
        return {
            "inertia": self.inertia,
            "potential": self.potential,
            "wave": self.wave,
            "rotor": self.rotor,
        }

    def replace(self, **hyperparameters: Floats) -> "Chain":
        """See `Kernel.replace`."""
        return replace(self, **hyperparameters)

    def _numbers(self) -> tuple[Floats, float, float, float]:
        return (
            np.ascontiguousarray(self.inertia),
            float(self.potential[0]),
            float(self.wave[0]),
            float(self.rotor[0]),
        )

    @staticmethod
    def _prepared(x: States) -> tuple[Floats, Floats, Floats, Floats, Floats]:
        return x.q, x.qd, x.qdd, np.sin(x.q), np.cos(x.q)

    def gram(self, x: States) -> Floats:
        """See `CoupledKernel.gram`."""
        size = len(x) * x.joints
        out = np.empty((size, size))
        chained.gram_lower(self._prepared(x), *self._numbers(), out)
        return out

    def cross(self, x: States, u: States) -> Floats:
        """See `CoupledKernel.cross`."""
        out = np.empty((len(x), x.joints, len(u), x.joints))
        chained.cross_blocks(self._prepared(x), self._prepared(u), *self._numbers(), out)
        return out.reshape(len(x) * x.joints, len(u) * x.joints)

    def apply(self, x: States, u: States, a: Floats) -> Floats:
        """See `Kernel.apply`; O(N²) a pair, no block is formed."""
        out = np.empty((len(x), x.joints))
        coefficients = np.ascontiguousarray(a)
        prepared = self._prepared(x), self._prepared(u)
        chained.apply_blocks(*prepared, *self._numbers(), coefficients, out)
        return out

    def variance(self, x: States) -> Floats:
        """See `Kernel.variance`."""
        out = np.empty((len(x), x.joints))
        chained.variances(self._prepared(x), *self._numbers(), out)
        return out
