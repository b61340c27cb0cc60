"""From torque to acceleration: forward dynamics of anything that gives torques."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from lagrangian_ff.errors import ModelError
from lagrangian_ff.kernels import States

Floats = NDArray[np.float64]
Torque = Callable[[States], Floats]

ROUNDS = 30
"""Steps at most towards the acceleration, where an effect makes torque bend over it."""
CLOSE = 1e-9
"""Share of the torque that may be left."""
NEAR = 1e-3
"""rad/s²: how far the slope is taken where it changes."""


def mass_of(torque: Torque, x: States, step: float = 1.0) -> Floats:
    """(M, N, N) the derivative of a torque by acceleration, by differences from the states on.

    Args:
        torque: (M, N) N·m of states; where it is affine in acceleration any step is exact.
        x: (M, N).
        step: rad/s².
    """
    joints = x.joints
    q, qd, qdd = (np.repeat(part, joints + 1, axis=0) for part in (x.q, x.qd, x.qdd))
    qdd += step * np.tile(np.vstack([np.zeros(joints), np.eye(joints)]), (len(x), 1))
    found = torque(States.of(q, qd, qdd)).reshape(len(x), joints + 1, joints)
    return np.asarray((found[:, 1:] - found[:, :1]).transpose(0, 2, 1)) / step


def least(mass: Floats) -> tuple[Floats, Floats]:
    """The least eigenvalue of each mass matrix (M, N, N), and its direction.

    Returns:
        (M,) and (M, N).
    """
    values, vectors = np.linalg.eigh(0.5 * (mass + mass.transpose(0, 2, 1)))
    return values[:, 0], vectors[:, :, 0]


def acceleration(torque: Torque, x: States, wanted: Floats) -> Floats:
    """(M, N) rad/s² at which a torque is what is wanted.

    Newton's method: where the torque is affine in acceleration one step arrives; where an effect
    follows the torque itself, a few.

    Args:
        torque: (M, N) N·m of states.
        x: (M, N); their acceleration does not matter.
        wanted: (M, N) N·m.

    Raises:
        ModelError: the mass matrix is not positive definite at some of the states, or no
            acceleration gives some of the torques.
    """
    qdd = np.zeros_like(x.q)
    mass = mass_of(torque, replace(x, qdd=qdd))
    _require_positive(mass)
    start = torque(replace(x, qdd=qdd))
    enough = CLOSE * (np.abs(wanted).max(axis=1) + np.abs(start).max(axis=1))
    left, open_ = wanted - start, np.arange(len(x))
    for _ in range(ROUNDS):
        qdd[open_] += np.linalg.solve(mass, left[:, :, None])[:, :, 0]
        left = wanted - torque(replace(x, qdd=qdd))
        open_ = np.flatnonzero(np.abs(left).max(axis=1) > enough)
        if not len(open_):
            return qdd
        left = left[open_]
        mass = mass_of(torque, replace(x, qdd=qdd).take(open_), NEAR)
    raise ModelError(
        f"no acceleration was found that gives the torque at sample {open_[0]}: an "
        "effect of the model follows the torque itself too strongly there"
    )


def _require_positive(mass: Floats) -> None:
    values, _ = least(mass)
    bad = np.flatnonzero(values <= 0.0)
    if len(bad):
        raise ModelError(
            f"the learned mass matrix is not positive definite at {len(bad)} of {len(mass)} "
            f"states, the first of them sample {bad[0]} (least eigenvalue {values[bad[0]]:.3g} "
            "kg·m²): forward dynamics is not defined there; stay within the motion the model was "
            "identified on, identify with more motion, or with --positive"
        )
