"""The motion a model knows: outside it, the model guesses."""

from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import NDArray

from lagrangian_ff.kernels import States

Floats = NDArray[np.float64]

STILL = 1e-3
"""rad, rad/s, rad/s²: what a joint that stood still may do and still stand."""


@dataclass(frozen=True)
class MotionRange:
    """The box of states a model was identified on.

    Attributes:
        q_low, q_high: (N,) rad.  qd_max: (N,) rad/s.  qdd_max: (N,) rad/s².
        tau_max: (N,) N·m, the largest torque met.
    """

    q_low: Floats
    q_high: Floats
    qd_max: Floats
    qdd_max: Floats
    tau_max: Floats

    @classmethod
    def of(cls, x: States, tau: Floats) -> "MotionRange":
        """The range of these states and torques."""
        return cls(
            x.q.min(axis=0),
            x.q.max(axis=0),
            np.abs(x.qd).max(axis=0),
            np.abs(x.qdd).max(axis=0),
            np.abs(tau).max(axis=0),
        )

    def excess(self, x: States) -> Floats:
        """(M, N) how far outside each joint's state is, in parts of the range; 0 inside.

        The largest excess of position, velocity and acceleration, each relative to the width of
        what was seen.
        """
        width = np.maximum(self.q_high - self.q_low, 2.0 * STILL)
        over = np.maximum(np.maximum(self.q_low - x.q, x.q - self.q_high) / width, 0.0)
        for rate, limit in ((x.qd, self.qd_max), (x.qdd, self.qdd_max)):
            over = np.maximum(over, np.abs(rate) / np.maximum(limit, STILL) - 1.0)
        return over

    def record(self) -> dict[str, list[float]]:
        """For JSON."""
        return {f.name: [float(v) for v in getattr(self, f.name)] for f in fields(self)}

    @classmethod
    def from_record(cls, record: dict[str, list[float]]) -> "MotionRange":
        """The range a record describes."""
        return cls(**{f.name: np.array(record[f.name], dtype=np.float64) for f in fields(cls)})
