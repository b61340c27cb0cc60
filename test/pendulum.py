"""A planar double pendulum with friction: torques in closed form, for tests of identification."""

import numpy as np
from numpy.typing import NDArray
from sines import sines

from lagrangian_ff.kernels import States
from lagrangian_ff.recording.motion import Motion

Floats = NDArray[np.float64]

JOINTS = ("shoulder", "elbow")
VISCOUS = np.array([2.0, 0.4])
COULOMB = np.array([3.0, 0.8])
OFFSET = np.array([0.5, -0.2])
WIDTH = 0.02


def mass_matrix(q: Floats) -> Floats:
    """(M, 2, 2) of two rods of 2 kg and 1 kg, 0.5 m and 0.4 m long, and geared rotors."""
    c = np.cos(q[:, 1])
    m = np.empty((len(q), 2, 2))
    m[:, 0, 0] = 2 * 0.25 / 3 + 0.25 + 0.16 / 3 + 0.2 * c + 0.3
    m[:, 0, 1] = m[:, 1, 0] = 0.16 / 3 + 0.1 * c
    m[:, 1, 1] = 0.16 / 3 + 0.05
    return m


def rigid_torque(x: States) -> Floats:
    """(M, 2) N·m of inertia, Coriolis and gravity."""
    s = 0.1 * np.sin(x.q[:, 1])
    coriolis = np.stack(
        [-s * (2 * x.qd[:, 0] * x.qd[:, 1] + x.qd[:, 1] ** 2), s * x.qd[:, 0] ** 2], axis=1
    )
    g = 9.81
    second = g * 0.2 * np.cos(x.q[:, 0] + x.q[:, 1])
    first = g * (2 * 0.25 + 0.5) * np.cos(x.q[:, 0]) + second
    inertia = np.einsum("inm,im->in", mass_matrix(x.q), x.qdd)
    return inertia + coriolis + np.stack([first, second], axis=1)


def friction_torque(x: States) -> Floats:
    """(M, 2) N·m of the friction basis with known parameters."""
    return VISCOUS * x.qd + COULOMB * np.tanh(x.qd / WIDTH) + OFFSET


def states(seconds: float, rate: float, seed: int) -> tuple[Floats, States]:
    """A smooth motion of six random sines a joint."""
    rng = np.random.default_rng(seed)
    t = np.arange(0.0, seconds, 1.0 / rate)
    return t, States.of(*sines(rng, t, 2, (0.5, 5.0)))


def motion(seconds: float = 30.0, rate: float = 100.0, seed: int = 0, noise: float = 0.0) -> Motion:
    """A recording of the pendulum, with torque noise of that share of each torque's spread."""
    t, x = states(seconds, rate, seed)
    tau = rigid_torque(x) + friction_torque(x)
    tau += noise * tau.std(axis=0) * np.random.default_rng(seed + 1000).normal(size=tau.shape)
    return Motion(
        joints=JOINTS, time=t, q=x.q, qd=x.qd, qdd=x.qdd, tau=tau,
        segment=np.zeros(len(t), dtype=np.int64), source="pendulum",
    )  # fmt: skip
