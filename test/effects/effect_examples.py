"""A motion of three joints as effects see it."""

from dataclasses import replace

import numpy as np

from lagrangian_ff.effects import Effect, Inputs
from lagrangian_ff.kernels import States

JOINTS = 3
RATE = 100.0  # Hz


def motion(seconds: float = 10.0, seed: int = 0) -> Inputs:
    """Smooth positions with reversals, their derivatives, and torques of a made-up arm."""
    rng = np.random.default_rng(seed)
    time = np.arange(round(seconds * RATE)) / RATE
    omega = rng.uniform(1.0, 4.0, (2, JOINTS))
    size = rng.uniform(0.3, 0.8, (2, JOINTS))
    phase = omega[:, None, :] * time[:, None] + rng.uniform(0.0, 6.0, (2, 1, JOINTS))
    q = (size[:, None, :] * np.sin(phase)).sum(axis=0)
    qd = ((size * omega)[:, None, :] * np.cos(phase)).sum(axis=0)
    qdd = -((size * omega**2)[:, None, :] * np.sin(phase)).sum(axis=0)
    load = 2.0 * qdd + 15.0 * np.cos(q)
    torque = load + 3.0 * qd + 2.0 * np.tanh(qd / 0.05)
    x = Inputs.of(States.of(q, qd, qdd), time=time, load=load, torque=torque)
    warm = 30.0 + 5.0 * np.sin(0.7 * time[:, None] + np.arange(JOINTS))
    return replace(x, sign_speed=np.array([0.02, 0.05, 0.1]), temperature=warm)


def shape_of(effect: Effect) -> dict[str, float]:
    """Its shape before any search."""
    return {shape.name: shape.start for shape in effect.shapes}


def shapes_of(effect: Effect, x: Inputs, joint: int) -> list[dict[str, float]]:
    """A few of the shapes that are tried."""
    tried = [dict(shape) for shape in effect.candidates(x, joint)]
    return tried[:: max(1, len(tried) // 5)]
