"""A small arm with known torques: what runs where the documentation shows the simulated one."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from lagrangian_ff.arm import Trajectory, write_trajectory
from lagrangian_ff.recording import Recording, write_bag

JOINTS = ("joint_2", "joint_3")
RATE, SECONDS = 100.0, 20.0
VISCOUS, COULOMB = (0.8, 0.3), (1.5, 0.6)  # N·m·s/rad, N·m
STRIBECK, CREEPING = 1.0, 0.15  # N·m, rad/s: what joint_3 hides
NOISE = 0.05  # N·m


def small_arm(path: Path, *, seed: int = 0, slow: bool = False) -> None:
    """Write a recording of two links of 1 m that carry 1 kg each, or as .csv its trajectory."""
    time = np.arange(round(SECONDS * RATE)) / RATE
    share = 0.5 if slow else 1.0
    speed = share * np.array([[1.1, 2.3, 3.7], [1.7, 2.9, 4.3]])
    size = share * np.array([[0.6, 0.3, 0.15], [0.7, 0.3, 0.1]])
    phase = speed * time[:, None, None] + np.array([[0.0, 1.0, 2.0], [0.5, 1.5, 2.5]]) + seed
    q = (size * np.sin(phase)).sum(axis=2)
    qd = (size * speed * np.cos(phase)).sum(axis=2)
    qdd = -(size * speed**2 * np.sin(phase)).sum(axis=2)
    if path.suffix == ".csv":
        write_trajectory(path, Trajectory(time, q, qd, qdd, joints=JOINTS))
        return
    c2, s2 = np.cos(q[:, 1]), np.sin(q[:, 1])
    g1, g2 = 9.81 * np.cos(q[:, 0]), 9.81 * np.cos(q[:, 0] + q[:, 1])
    coupling = s2 * (2.0 * qd[:, 0] * qd[:, 1] + qd[:, 1] ** 2)
    first = (3.0 + 2.0 * c2) * qdd[:, 0] + (1.0 + c2) * qdd[:, 1] - coupling + 2.0 * g1 + g2
    second = (1.0 + c2) * qdd[:, 0] + qdd[:, 1] + s2 * qd[:, 0] ** 2 + g2
    tau = np.stack([first, second], axis=1) + np.array(VISCOUS) * qd
    sign = np.tanh(qd / 0.02)
    tau += np.array(COULOMB) * sign
    tau[:, 1] += STRIBECK * sign[:, 1] * np.exp(-((qd[:, 1] / CREEPING) ** 2))
    tau += np.random.default_rng(seed).normal(0.0, NOISE, tau.shape)
    write_bag(path, Recording(JOINTS, time, q, qd, tau, 1_700_000_000.0))
