"""Two rods in a vertical plane, with friction and, where asked, physics that no model was told."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray
from sines import sines

from lagrangian_ff.effects.memory import stop
from lagrangian_ff.recording.motion import Motion

Floats = NDArray[np.float64]
Hidden = Callable[[Floats, Floats, Floats, Floats], Floats]

JOINTS = ("shoulder", "elbow")
NOISE = np.array([0.15, 0.05])  # N·m
WIDTH = 0.02  # rad/s
BENDS = 0.009  # rad
LOAD = 0.8  # kg at the end of the second rod


def rods(q: Floats, qd: Floats, qdd: Floats, load: Floats | float = 0.0) -> Floats:
    """(M, 2) N·m of rods of 2 kg and 1 kg, 0.5 m and 0.4 m, with `load` kg (M,) at the end."""
    load = np.asarray(load)
    c, s = np.cos(q[:, 1]), np.sin(q[:, 1])
    own, tip = 1.0 * 0.2 + load * 0.4, 1.0 * 0.16 / 3 + load * 0.16
    first = 2 * 0.25 / 3 + 0.25 + load * 0.25 + 0.3
    cross = 0.5 * own * c
    inertia = np.stack(
        [
            (first + tip + 2 * cross) * qdd[:, 0] + (tip + cross) * qdd[:, 1],
            (tip + cross) * qdd[:, 0] + (tip + 0.05) * qdd[:, 1],
        ],
        axis=1,
    )
    turning = 0.5 * own * s
    inertia[:, 0] -= turning * (2 * qd[:, 0] * qd[:, 1] + qd[:, 1] ** 2)
    inertia[:, 1] += turning * qd[:, 0] ** 2
    second = 9.81 * own * np.cos(q[:, 0] + q[:, 1])
    weight = 9.81 * (0.5 + 0.5 + 0.5 * load) * np.cos(q[:, 0]) + second
    return np.asarray(inertia + np.stack([weight, second], axis=1))


def motion(
    seed: int, seconds: float = 40.0, hidden: Hidden | None = None, *, load_since: float = np.inf
) -> Motion:
    """A recording at 100 Hz.

    Args:
        seed: of motion and noise.  seconds: its length.
        hidden: (t, q, qd, qdd) -> (M, 2) N·m that is added.
        load_since: s, when `LOAD` is taken up.
    """
    rng = np.random.default_rng(seed)
    t = np.arange(0.0, seconds, 0.01)
    q, qd, qdd = sines(rng, t, 2, (0.4, 4.0))
    tau = rods(q, qd, qdd, np.where(t >= load_since, LOAD, 0.0))
    tau += np.array([2.0, 0.4]) * qd + np.array([3.0, 0.8]) * np.tanh(qd / WIDTH)
    if hidden is not None:
        tau += hidden(t, q, qd, qdd)
    tau += NOISE * rng.normal(size=tau.shape)
    segment = np.zeros(len(t), dtype=np.int64)
    return Motion(JOINTS, t, q, qd, qdd, tau, segment, f"rods {seed}")


def stick(t: Floats, q: Floats, qd: Floats, qdd: Floats) -> Floats:
    """More dry friction of the elbow below 0.15 rad/s."""
    v = qd[:, 1]
    more = 0.6 * np.tanh(v / WIDTH) * np.exp(-((v / 0.15) ** 2))
    return np.stack([np.zeros_like(v), more], axis=1)


def presliding(t: Floats, q: Floats, qd: Floats, qdd: Floats) -> Floats:
    """Most of the elbow's dry friction builds up over `BENDS`."""
    sign, segment = np.tanh(qd[:, 1] / WIDTH), np.zeros(len(t), dtype=np.int64)
    late = 0.7 * (stop(q[:, 1], segment, sign, BENDS) - sign)
    return np.stack([np.zeros(len(t)), late], axis=1)


def sore_spot(t: Floats, q: Floats, qd: Floats, qdd: Floats) -> Floats:
    """More dry friction of the shoulder within a tenth of a radian: no effect has this form."""
    near = np.exp(-(((q[:, 0] - 0.2) / 0.1) ** 2))
    return np.stack([3.0 * np.tanh(qd[:, 0] / WIDTH) * near, np.zeros(len(t))], axis=1)


def thick_and_sore(t: Floats, q: Floats, qd: Floats, qdd: Floats) -> Floats:
    """Drag of the shoulder, and a sore spot in it."""
    drag = np.outer(5.0 * qd[:, 0] * np.abs(qd[:, 0]), [1.0, 0.0])
    return drag + 0.5 * sore_spot(t, q, qd, qdd)
