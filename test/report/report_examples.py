"""Small findings to draw: what a model of two joints could have given."""

import numpy as np

from lagrangian_ff.diagnosis import Comparison
from lagrangian_ff.identification import Score
from lagrangian_ff.identification.records import Estimate, FittedEffect
from lagrangian_ff.recording import Motion
from lagrangian_ff.report import Tracking

JOINTS = ("shoulder", "elbow")


def motion(seconds: float = 2.0, joints: tuple[str, ...] = JOINTS) -> Motion:
    """Sines of different size, in two segments."""
    time = np.arange(0.0, seconds, 0.01)
    tau = np.stack([(n + 1) * np.sin((n + 2) * time) for n in range(len(joints))], axis=1)
    zero = np.zeros_like(tau)
    segment = (time > 0.5 * seconds).astype(np.int64)
    return Motion(joints, time, zero, zero, zero, tau, segment)


def comparison() -> Comparison:
    """A prediction that misses a tenth of the torque and a constant."""
    measured = motion()
    predicted = 0.9 * measured.tau + 0.05
    score = Score.of(measured.joints, measured.tau, predicted)
    return Comparison(measured, predicted, score, outside=0.125)


def runs() -> list[Tracking]:
    """Three runs, each better than the one before."""
    time = np.arange(0.0, 3.0, 0.01)
    error = np.stack([0.02 * np.sin(time), 0.01 * np.cos(time)], axis=1)
    return [
        Tracking(label, JOINTS, time, factor * error)
        for label, factor in (("none", 1.0), ("some", 0.5), ("<all> & more", 0.1))
    ]


def effects() -> list[FittedEffect]:
    """Return friction on every joint."""
    return [
        FittedEffect(
            "coulomb",
            joint,
            "F_c tanh(qd / v0)",
            {"F_c": Estimate(1.5 + n, 1.25 + n, 1.75 + n, "N·m")},
            {"v0": 0.02},
            {"v0": "0.0200"},
        )
        for n, joint in enumerate(JOINTS)
    ]
