"""How far predicted torques are from measured ones, in the two units people use."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Score:
    """Errors of predicted torque, per joint.

    Attributes:
        joints: names.
        rmse: (N,) N·m, root mean square.
        nmse: (N,) mean squared error over the variance of the measured torque: 0 is perfect, 1 is
            no better than the mean; NaN where the torque did not vary.
    """

    joints: tuple[str, ...]
    rmse: Floats
    nmse: Floats

    @classmethod
    def of(cls, joints: tuple[str, ...], measured: Floats, predicted: Floats) -> "Score":
        """Compare (M, N) torques in N·m."""
        squared = np.mean((measured - predicted) ** 2, axis=0)
        variance = np.var(measured, axis=0)
        with np.errstate(divide="ignore", invalid="ignore"):
            nmse = np.where(variance > 0.0, squared / variance, np.nan)
        return cls(joints, np.sqrt(squared), nmse)

    def record(self) -> dict[str, object]:
        """For JSON: per joint, the root mean square over joints, and the mean nmse."""
        return {
            "joints": {
                name: {"rmse": float(r), "nmse": float(n)}
                for name, r, n in zip(self.joints, self.rmse, self.nmse, strict=True)
            },
            "rmse": float(np.sqrt(np.mean(self.rmse**2))),
            "nmse": float(np.nanmean(self.nmse)) if np.isfinite(self.nmse).any() else float("nan"),
        }
