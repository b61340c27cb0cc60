"""A model of two joints, identified in a second from a motion whose torques can be written down."""

from pathlib import Path

import numpy as np

from lagrangian_ff.identification import Model, Settings, identify
from lagrangian_ff.recording import Motion

JOINTS = ("a", "b")


def save_small_model(path: Path) -> Model:
    """Identify, save, and return it."""
    time = np.arange(0.0, 30.0, 0.02)
    phase = time[:, None]
    q, qd, qdd = (np.zeros((len(time), 2)) for _ in range(3))
    for amplitude, speed in ((0.5, (1.1, 1.7)), (0.4, (3.1, 3.7))):
        w = np.array(speed)
        q += amplitude * np.sin(w * phase)
        qd += amplitude * w * np.cos(w * phase)
        qdd -= amplitude * w**2 * np.sin(w * phase)
    tau = 8.0 * np.cos(q) + 1.5 * qdd + 0.4 * qd + np.tanh(qd / 0.02)
    motion = Motion(JOINTS, time, q, qd, qdd, tau, np.zeros(len(time), dtype=np.int64))
    model = identify(motion, Settings(train=1.0, samples=60, evaluations=5)).model
    model.save(path)
    return model
