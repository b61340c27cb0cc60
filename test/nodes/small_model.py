"""A model of two joints, identified in a second from a motion whose torques can be written down."""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from lagrangian_ff.identification import Model, Settings, identify
from lagrangian_ff.recording import Motion, Recording, write_bag

JOINTS = ("a", "b")
Floats = NDArray[np.float64]


def motion_at(time: Floats) -> tuple[Floats, Floats, Floats]:
    """Return q, qd and qdd, (M, 2) each, at these times (M,)."""
    phase = time[:, None]
    q, qd, qdd = (np.zeros((len(time), 2)) for _ in range(3))
    for amplitude, speed in ((0.5, (1.1, 1.7)), (0.4, (3.1, 3.7))):
        w = np.array(speed)
        q += amplitude * np.sin(w * phase)
        qd += amplitude * w * np.cos(w * phase)
        qdd -= amplitude * w**2 * np.sin(w * phase)
    return q, qd, qdd


def torque_of(q: Floats, qd: Floats, qdd: Floats) -> Floats:
    """Return the torque (M, 2) N·m of the arm as the model knows it."""
    return np.asarray(8.0 * np.cos(q) + 1.5 * qdd + 0.4 * qd + np.tanh(qd / 0.02))


def save_small_model(path: Path, joints: tuple[str, str] = JOINTS, factor: float = 1.0) -> Model:
    """Identify the model, save it, and return it; `factor` multiplies its torques."""
    time = np.arange(0.0, 30.0, 0.02)
    q, qd, qdd = motion_at(time)
    tau = factor * torque_of(q, qd, qdd)
    motion = Motion(joints, time, q, qd, qdd, tau, np.zeros(len(time), dtype=np.int64))
    model = identify(motion, Settings(train=1.0, samples=60, evaluations=5)).model
    model.save(path)
    return model


def recorded_bag(path: Path, drag: float) -> Path:
    """Write a bag of the same motion with noise, and drag in N·m·s²/rad² on joint b."""
    time = np.arange(0.0, 30.0, 0.01)
    q, qd, qdd = motion_at(time)
    tau = torque_of(q, qd, qdd) + 0.05 * np.random.default_rng(0).standard_normal(q.shape)
    tau[:, 1] += drag * qd[:, 1] * np.abs(qd[:, 1])
    return write_bag(path, Recording(JOINTS, time, q, qd, tau, start=1.7e9))
