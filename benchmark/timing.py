"""What the benchmarks share: a motion to learn from, and times."""

import time
from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from lagrangian_ff.kernels import States

Floats = NDArray[np.float64]


REST = 0.1  # s


def seconds(work: Callable[[], object]) -> float:
    """Wall time of one call, after a rest in which the threads of BLAS stop turning idly."""
    time.sleep(REST)
    began = time.perf_counter()
    work()
    return time.perf_counter() - began


def medians(works: Sequence[Callable[[], object]], repeats: int) -> Floats:
    """Median wall time of each, all in turn, so that a busy moment meets all of them.

    Each runs once before: the first call compiles.
    """
    for work in works:
        work()
    return np.asarray(
        np.median([[seconds(work) for work in works] for _ in range(repeats)], axis=0)
    )


def states(samples: int, joints: int, seed: int = 0) -> tuple[States, Floats]:
    """Random states and torques with inertia, gravity and friction; (samples, joints) each."""
    rng = np.random.default_rng(seed)
    shape = (samples, joints)
    x = States.of(rng.uniform(-2, 2, shape), rng.normal(size=shape), 3 * rng.normal(size=shape))
    return x, rng.normal(size=shape) + 2 * x.qdd + 5 * np.sin(x.q) + 3 * np.sign(x.qd)


def moving(
    rng: np.random.Generator, t: Floats, joints: int
) -> tuple[Floats, Floats, Floats, Floats]:
    """q, qd, qdd and torque, (samples, joints) each, of an arm with gravity, inertia and friction.

    Each joint carries the links behind it, so that the torques have a Lagrangian.
    """
    q, qd, qdd = np.zeros((3, len(t), joints))
    for _ in range(6):
        omega, phase = rng.uniform(0.4, 4.0, joints), rng.uniform(0, 2 * np.pi, joints)
        size = rng.uniform(0.3, 0.8, joints) / omega**0.7
        angle = omega * t[:, None] + phase
        q += size * np.sin(angle)
        qd += size * omega * np.cos(angle)
        qdd -= size * omega**2 * np.sin(angle)
    weight = 3.0 * np.cos(np.cumsum(q, axis=1))
    gravity = np.cumsum(weight[:, ::-1], axis=1)[:, ::-1]
    return q, qd, qdd, 2.0 * qdd + gravity + 1.5 * qd + 3.0 * np.tanh(qd / 0.02)
