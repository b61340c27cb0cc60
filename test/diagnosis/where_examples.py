"""Motions and residuals with a known place of failure."""

import numpy as np
from numpy.typing import NDArray
from scipy.signal import lfilter

from lagrangian_ff.diagnosis.where import ResidualSeries
from lagrangian_ff.recording.motion import Motion

Floats = NDArray[np.float64]

RATE = 100.0


def motion(seed: int = 0, seconds: float = 60.0) -> Motion:
    """One joint that moves by six random sines."""
    rng = np.random.default_rng(seed)
    t = np.arange(0.0, seconds, 1.0 / RATE)
    q, qd, qdd = np.zeros((3, len(t)))
    for _ in range(6):
        omega, phase = rng.uniform(0.5, 5.0), rng.uniform(0.0, 2.0 * np.pi)
        size = rng.uniform(0.3, 0.8) / omega**0.7
        q += size * np.sin(omega * t + phase)
        qd += size * omega * np.cos(omega * t + phase)
        qdd -= size * omega**2 * np.sin(omega * t + phase)
    return single(t, q, qd, qdd)


def single(t: Floats, q: Floats, qd: Floats, qdd: Floats) -> Motion:
    """The motion of one joint, its torque zero."""
    segment = np.zeros(len(t), dtype=np.int64)
    tau = np.zeros((len(t), 1))
    return Motion(("joint",), t, q[:, None], qd[:, None], qdd[:, None], tau, segment, "sines")


def noise(count: int, seed: int, seconds: float = 0.2) -> Floats:
    """Of spread 1, correlated over so many seconds."""
    keep = np.exp(-1.0 / (seconds * RATE))
    white = np.random.default_rng(seed).normal(size=count + 1000)
    return np.asarray(lfilter([np.sqrt(1.0 - keep**2)], [1.0, -keep], white)[1000:])


def series(moved: Motion, residual: Floats, excess: Floats | None = None) -> ResidualSeries:
    """What is looked at, with a load that goes with the position."""
    away = np.zeros(len(moved)) if excess is None else excess
    return ResidualSeries(moved, residual[:, None], 10.0 * np.sin(moved.q), away)
