"""What the benchmarks share: a motion to learn from, and times."""

import time
from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from lagrangian_ff.kernels import States

Floats = NDArray[np.float64]


def seconds(work: Callable[[], object]) -> float:
    """Wall time of one call."""
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
