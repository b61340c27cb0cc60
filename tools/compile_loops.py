"""Compile the loops of all kernels once, so that what runs next finds them compiled.

Numba keeps what it compiled beside the sources; a second run of this takes two seconds::

    python tools/compile_loops.py
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))

from lagrangian_ff.kernels import (  # noqa: E402
    KERNELS,
    CoupledKernel,
    DifferentiableKernel,
    IndependentKernel,
    Kernel,
    LagrangianKernel,
    States,
)
from lagrangian_ff.kernels.rigid import Tree  # noqa: E402


def use(kernel: Kernel, x: States) -> None:
    """Let a kernel do all that it can."""
    kernel.learned(x, x.q).torque(x)
    kernel.apply(x, x, x.q)
    kernel.variance(x)
    if isinstance(kernel, CoupledKernel):
        kernel.gram(x)
        kernel.cross(x, x)
    if isinstance(kernel, DifferentiableKernel):
        kernel.contract(x, np.eye(x.q.size), x.q.ravel())
    if isinstance(kernel, IndependentKernel):
        kernel.gram(x, 0)
        kernel.cross(x, x, 0)
    if isinstance(kernel, LagrangianKernel):
        kernel.lagrangian(x, x, x.q)
        kernel.momentum(x, x, x.q)


def pole() -> Tree:
    """One body that the first joint turns."""
    one, axis = np.ones(1), np.array([[0.0, 0.0, 1.0]])
    return Tree(
        parent=np.array([-1]), rotation=np.eye(3)[None], offset=0.0 * axis, axis=axis,
        sliding=0.0 * one, driver=np.array([0]), ratio=one, shift=0.0 * one,
        inertial=np.ones((1, 10)), gravity=-9.81 * axis[0],
    )  # fmt: skip


if __name__ == "__main__":
    states = States.of(*np.random.default_rng(0).normal(size=(3, 4, 2)))
    for kind in KERNELS.values():
        use(kind.start(states), states)
    pole().regressor(states)
