"""A model of two joints whose terms can be written down, for tests of the logic around it."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lagrangian_ff.identification.predicting import MotionRange, Terms

Floats = NDArray[np.float64]

OFFSET = 3.0  # N·m of gravity that the identification took for a constant


RANGE = MotionRange(
    q_low=np.full(2, -2.0),
    q_high=np.full(2, 2.0),
    qd_max=np.full(2, 3.0),
    qdd_max=np.full(2, 20.0),
    tau_max=np.full(2, 50.0),
)


@dataclass(frozen=True)
class FakeModel:
    joints: tuple[str, ...] = ("a", "b")
    range: MotionRange = RANGE

    def terms(self, q: Floats, qd: Floats, qdd: Floats) -> Terms:
        return Terms(
            gravity=10.0 * np.cos(q) - OFFSET,
            inertia=2.0 * qdd,
            coriolis=0.3 * qd**2,
            effects={
                "viscous": 0.5 * qd,
                "coulomb": np.tanh(qd / 0.01),
                "offset": np.full_like(q, OFFSET),
            },
        )

    def predict(self, q: Floats, qd: Floats, qdd: Floats) -> Floats:
        return (
            10.0 * np.cos(q) + 2.0 * qdd + 0.3 * qd**2 + 0.5 * qd + np.tanh(qd / 0.01)
        )  # fmt: skip
