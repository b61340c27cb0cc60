"""What is assumed of the rigid-body part and of the noise before the torques are seen."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from lagrangian_ff.effects import Inputs
from lagrangian_ff.kernels import States
from lagrangian_ff.kernels.prefixes import Prefixes

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Prior:
    """A serial arm of unknown masses, and white noise of its own on every joint.

    Attributes:
        kernel: of the rigid-body torques, in units of `unit`.
        noise: (N,) variance of the noise, in the same units.
        unit: (N,) N·m that count as one; they differ between joints only by `gain`.
        change: an interval of time, in s, in which another Lagrangian is added to the arm's own, as
            with a load at the hand, and its variance in parts of the first; None: there is none.
    """

    kernel: Prefixes
    noise: Floats
    unit: Floats
    change: tuple[float, float, float] | None = None

    def gram(self, x: Inputs) -> Floats:
        """(S N, S N) of the rigid-body torques, in units of `unit`."""
        gram = self.kernel.gram(States(x.q, x.qd, x.qdd))
        if self.change is not None:
            rows = np.flatnonzero(np.repeat(self._within(x), x.joints))
            if len(rows) and rows[-1] - rows[0] == len(rows) - 1:
                part = slice(rows[0], rows[-1] + 1)
                gram[part, part] *= 1.0 + self.change[2]
            elif len(rows):
                gram[np.ix_(rows, rows)] *= 1.0 + self.change[2]
        return gram

    def torque(self, x: Inputs, centres: Inputs, weights: Floats) -> Floats:
        """(M, N) N·m of the rigid-body part without the rotors, for weights (S, N)."""
        kernel = self.kernel.replace(rotor=np.zeros(1))
        at, of = States(x.q, x.qd, x.qdd), States(centres.q, centres.qd, centres.qdd)
        torque = kernel.apply(at, of, weights)
        if self.change is not None:
            inside = weights * self._within(centres)[:, None]
            torque += self.change[2] * kernel.apply(at, of, inside) * self._within(x)[:, None]
        return np.asarray(torque * self.unit)

    def _within(self, x: Inputs) -> NDArray[np.bool_]:
        """(M,) which samples lie in the interval of the change."""
        assert self.change is not None
        since, until, _ = self.change
        return (x.time >= since) & (x.time < until)

    def rotors(self, x: Inputs, centres: Inputs, weights: Floats) -> Floats:
        """(M, N) N·m of the rotors, for weights (S, N)."""
        return np.asarray(x.qdd * self.rotor(centres, weights))

    def rotor(self, centres: Inputs, weights: Floats) -> Floats:
        """(N,) kg·m² of the rotors, for weights (S, N)."""
        own = float(self.kernel.rotor[0]) * self.kernel.inertia**2
        return np.asarray(own * np.sum(centres.qdd * weights, axis=0) * self.unit)

    @classmethod
    def start(cls, tau: Floats) -> "Prior":
        """Before any search; tau (M, N) N·m gives the scale."""
        joints = tau.shape[1]
        spread = np.std(tau, axis=0)
        unit = spread.max(initial=0.0) or 1.0
        share = np.maximum(spread / unit, 1e-4) ** 2
        kernel = Prefixes(
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
        kernel = Prefixes(
            inertia=values[:joints],
            potential=values[joints : joints + 1],
            wave=np.minimum(values[joints + 1 : joints + 2], 1.0),
            rotor=values[joints + 2 : joints + 3],
        )
        return replace(self, kernel=kernel, noise=values[joints + 3 :])

    def with_gain(self, gain: Floats) -> "Prior":
        """The prior with the units of the joints at these ratios."""
        return replace(self, unit=self.unit[0] * gain)
