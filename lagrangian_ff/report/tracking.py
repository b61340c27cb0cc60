"""How far a robot was from where it should have been."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Tracking:
    """One run along a trajectory.

    Attributes:
        label: what was done differently in this run, e.g. `no feedforward`.
        joints: N names.
        time: (M,) s since the start of the trajectory.
        error: (M, N) rad, reference less measured position.
    """

    label: str
    joints: tuple[str, ...]
    time: Floats
    error: Floats

    @property
    def rms(self) -> Floats:
        """(N,) rad, root mean square over the run."""
        return np.sqrt(np.mean(self.error**2, axis=0))

    @property
    def total(self) -> float:
        """Root mean square over run and joints, rad."""
        return float(np.sqrt(np.mean(self.error**2)))

    def record(self) -> dict[str, object]:
        """For JSON, in rad."""
        return {
            "label": self.label,
            "unit": "rad",
            "rms": self.total,
            "largest": float(np.abs(self.error).max()),
            "joints": {
                name: {"rms": float(rms), "largest": float(largest)}
                for name, rms, largest in zip(
                    self.joints, self.rms, np.abs(self.error).max(axis=0), strict=True
                )
            },
            "samples": len(self.time),
        }
