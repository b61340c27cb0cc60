"""The kernel of a serial arm: quadratic in velocity, gravity apart, joints in their order."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from lagrangian_ff.kernels import prefixed
from lagrangian_ff.kernels.base import Hyperparameter, largest
from lagrangian_ff.kernels.compiled import CompiledKernel
from lagrangian_ff.kernels.states import States

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Prefixes(CompiledKernel):
    """One Lagrangian, a sum over the prefixes of a serial chain; see `prefixed`.

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

    loops: ClassVar[Any] = prefixed
    name: ClassVar[str] = "prefixes"
    meaning: ClassVar[str] = "one Lagrangian of a serial arm: quadratic in velocity, gravity apart"
    searched: ClassVar[tuple[Hyperparameter, ...]] = (
        Hyperparameter("inertia", "s²/rad²", "Λ: weight of the joints' motion", 1e-3, 1e3),
        Hyperparameter("potential", "1", "λ: weight of gravity against inertia", 1e-3, 1e3),
        Hyperparameter("wave", "1", "ω: how much the Lagrangian changes with angles", 1e-3, 10.0),
    )

    @classmethod
    def start(cls, x: States) -> "Prefixes":
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

    def replace(self, **hyperparameters: Floats) -> "Prefixes":
        """See `Kernel.replace`."""
        return replace(self, **hyperparameters)

    def _weights(self, joints: int) -> tuple[Floats, float, float, float]:
        return (
            np.ascontiguousarray(self.inertia),
            float(self.potential[0]),
            float(self.wave[0]),
            float(self.rotor[0]),
        )
