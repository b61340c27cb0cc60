"""What is assumed of the rigid-body part and of the noise before the torques are seen."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lagrangian_ff.kernels.chain import Chain

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Prior:
    """A serial arm of unknown masses, and white noise of its own on every joint.

    Attributes:
        kernel: of the rigid-body torques, in units of `unit`.
        noise: (N,) variance of the noise, in the same units.
        unit: (N,) N·m that count as one; they differ between joints only by `gain`.
    """

    kernel: Chain
    noise: Floats
    unit: Floats

    @classmethod
    def start(cls, tau: Floats) -> "Prior":
        """Before any search; tau (M, N) N·m gives the scale."""
        joints = tau.shape[1]
        spread = np.std(tau, axis=0)
        unit = spread.max(initial=0.0) or 1.0
        share = np.maximum(spread / unit, 1e-4) ** 2
        kernel = Chain(
            inertia=np.full(joints, np.exp(-4.0)),
            potential=np.ones(1),
            wave=np.array([0.05]),
            rotor=np.array([np.exp(4.0)]),
        )
        return cls(kernel, np.exp(-6.0) * share, np.full(joints, unit))

    @property
    def gain(self) -> Floats:
        """(N,) how many N·m of the arm a unit of each joint's effort is, relative to the first."""
        return np.asarray(self.unit / self.unit[0])

    def vector(self) -> Floats:
        """All numbers but the units, as logarithms."""
        kernel = self.kernel
        parts = (kernel.inertia, kernel.potential, kernel.wave, kernel.rotor, self.noise)
        return np.log(np.concatenate(parts))

    def at(self, vector: Floats) -> "Prior":
        """The prior with the numbers of `vector`."""
        joints = len(self.noise)
        values = np.exp(np.clip(vector, -40.0, 40.0))
        kernel = Chain(
            inertia=values[:joints],
            potential=values[joints : joints + 1],
            wave=np.minimum(values[joints + 1 : joints + 2], 1.0),
            rotor=values[joints + 2 : joints + 3],
        )
        return Prior(kernel, values[joints + 3 :], self.unit)

    def with_gain(self, gain: Floats) -> "Prior":
        """The prior with the units of the joints at these ratios."""
        return Prior(self.kernel, self.noise, self.unit[0] * gain)
