"""Joint states at which kernels and effects are evaluated."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from lagrangian_ff.arrays import Floats, Ints
from lagrangian_ff.errors import ModelError


@dataclass(frozen=True)
class States:
    """Position, velocity and acceleration of N joints at M samples, the paper's x.

    Attributes:
        q: (M, N) rad.  qd: (M, N) rad/s.  qdd: (M, N) rad/s².
    """

    q: Floats
    qd: Floats
    qdd: Floats

    @classmethod
    def of(cls, q: ArrayLike, qd: ArrayLike, qdd: ArrayLike) -> "States":
        """Return states from any arrays of one shape, (M, N) or one state (N,).

        Raises:
            ModelError: the three shapes differ.
        """
        arrays = [np.atleast_2d(np.ascontiguousarray(a, dtype=np.float64)) for a in (q, qd, qdd)]
        if len({a.shape for a in arrays}) != 1 or arrays[0].ndim != 2:
            shapes = ", ".join(str(np.shape(a)) for a in (q, qd, qdd))
            raise ModelError(f"q, qd and qdd need one shape (samples, joints), got {shapes}")
        return cls(*arrays)

    def __len__(self) -> int:
        return int(self.q.shape[0])

    @property
    def joints(self) -> int:
        """Return the number of joints N."""
        return int(self.q.shape[1])

    def take(self, index: "Ints | slice") -> "States":
        """Return the states at these indices."""
        return States.of(self.q[index], self.qd[index], self.qdd[index])

    def at_rest(self) -> "States":
        """Return the same positions without velocity and acceleration, where only gravity acts."""
        zero = np.zeros_like(self.q)
        return States(self.q, zero, zero)

    def without_velocity(self) -> "States":
        """Return the same positions and accelerations without velocity."""
        return States(self.q, np.zeros_like(self.q), self.qdd)


def contiguous(x: States) -> tuple[Floats, Floats, Floats]:
    """Return q, qd, qdd in the layout that the loops read."""
    return tuple(np.ascontiguousarray(part, dtype=np.float64) for part in (x.q, x.qd, x.qdd))  # type: ignore[return-value]


def prepared(x: States) -> Floats:
    """Return (M, 5, N): q, qd, qdd, sin q and cos q of every state."""
    out = np.empty((len(x), 5, x.joints))
    out[:, 0], out[:, 1], out[:, 2] = x.q, x.qd, x.qdd
    out[:, 3], out[:, 4] = np.sin(x.q), np.cos(x.q)
    return out
