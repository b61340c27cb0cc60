"""What is assumed of the rigid-body part and of the noise before the torques are seen."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from lagrangian_ff.effects import Inputs
from lagrangian_ff.identification.choosing.ascent import numbers
from lagrangian_ff.kernels import States
from lagrangian_ff.kernels.structured.chain import Chain

Floats = NDArray[np.float64]

START_NOISE = 1e-2
"""Variance of the noise, in parts of the prior's, before any search."""


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

    kernel: Chain
    noise: Floats
    unit: Floats
    change: tuple[float, float, float] | None = None

    def gram(self, x: Inputs) -> Floats:
        """(S N, S N) of the rigid-body torques, in units of `unit`."""
        gram = self.kernel.gram(States(x.q, x.qd, x.qdd))
        if self.change is not None:
            rows = np.flatnonzero(np.repeat(within(self.change, x), x.joints))
            with np.errstate(all="ignore"):  # what memory held above the diagonal
                if len(rows) and rows[-1] - rows[0] == len(rows) - 1:
                    part = slice(rows[0], rows[-1] + 1)
                    gram[part, part] *= 1.0 + self.change[2]
                elif len(rows):
                    gram[np.ix_(rows, rows)] *= 1.0 + self.change[2]
        return gram

    def torque(self, x: Inputs, centres: Inputs, weights: Floats) -> Floats:
        """(M, N) N·m of the rigid-body part without the rotors, for weights (S, N)."""
        kernel = self.kernel.replace(rotor=np.zeros(x.joints))
        at, of = States(x.q, x.qd, x.qdd), States(centres.q, centres.qd, centres.qdd)
        torque = kernel.learned(of, weights).torque(at)
        if self.change is not None:
            inside = weights * within(self.change, centres)[:, None]
            added = kernel.learned(of, inside).torque(at)
            torque += self.change[2] * added * within(self.change, x)[:, None]
        return np.asarray(torque * self.unit)

    def second(self, x: Inputs) -> Floats | None:
        """(S N,) m of the Gram matrix K + K ∘ m mᵀ, where there is a change; see `gram`."""
        if self.change is None:
            return None
        return np.repeat(np.sqrt(self.change[2]) * within(self.change, x), x.joints)

    def rotors(self, x: Inputs, centres: Inputs, weights: Floats) -> Floats:
        """(M, N) N·m of the rotors, for weights (S, N)."""
        return np.asarray(x.qdd * self.rotor(centres, weights))

    def rotor(self, centres: Inputs, weights: Floats) -> Floats:
        """(N,) kg·m² of the rotors, for weights (S, N)."""
        own = self.kernel.rotor * self.kernel.inertia**2
        return np.asarray(own * np.sum(centres.qdd * weights, axis=0) * self.unit)

    @classmethod
    def start(cls, tau: Floats, states: States, sliding: Floats | None = None) -> "Prior":
        """Before any search.

        Args:
            tau: (M, N) N·m and states: (M, N) give the scales.
            sliding: (N,) 1 where a joint slides; None where all turn.
        """
        spread = np.std(tau, axis=0)
        unit = spread.max(initial=0.0) or 1.0
        share = np.maximum(spread / unit, 1e-4) ** 2
        kernel = Chain.start(states)
        if sliding is not None:
            kernel = kernel.replace(prismatic=sliding)
        noise = START_NOISE * share * kernel.variance(states).mean()
        return cls(kernel, noise, np.full(tau.shape[1], unit))

    @property
    def gain(self) -> Floats:
        """(N,) how many N·m of the arm a unit of each joint's effort is, relative to the first."""
        return np.asarray(self.unit / self.unit[0])

    def vector(self) -> Floats:
        """All numbers but the units, as logarithms, in the order of `slopes_by_gram`."""
        return np.log(np.concatenate([*numbers(self.kernel).values(), self.noise]))

    def at(self, vector: Floats) -> "Prior":
        """The prior with the numbers of `vector`."""
        left, kernel = np.exp(np.clip(vector, -40.0, 40.0)), {}
        for name, value in numbers(self.kernel).items():
            kernel[name], left = left[: len(value)], left[len(value) :]
        return replace(self, kernel=self.kernel.replace(**kernel), noise=left)

    def with_gain(self, gain: Floats) -> "Prior":
        """The prior with the units of the joints at these ratios."""
        return replace(self, unit=self.unit[0] * gain)


def within(change: tuple[float, float, float], x: Inputs) -> NDArray[np.bool_]:
    """(M,) which samples lie in the interval of a change."""
    since, until, _ = change
    return (x.time >= since) & (x.time < until)
