"""One of the motions, for these joints and limits."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lagrangian_ff.diagnosis.excite.limits import Limits
from lagrangian_ff.diagnosis.excite.many_joints import movable
from lagrangian_ff.diagnosis.excite.motions import NEXT_MOTIONS
from lagrangian_ff.diagnosis.excite.path import REST, Path, Reference
from lagrangian_ff.errors import ModelError

Floats = NDArray[np.float64]

SHORTEST, LONGEST = 5.0, 3600.0
"""s"""
_SLACK = 1e-9  # rad


def excite(
    motion: str,
    joints: Sequence[str],
    limits: Limits,
    *,
    joint: str | None = None,
    start: ArrayLike | None = None,
    pose: ArrayLike | None = None,
    duration: float | None = None,
    seed: int = 0,
) -> Reference:
    """A motion that shows effects or tells look-alikes apart.

    Args:
        motion: one of `NEXT_MOTIONS`.
        joints: N names.
        limits: never left.
        joint: the one to look at; None for all.
        start: (N,) rad, where it begins and ends; None for the pose.
        pose: (N,) rad, where the other joints are held meanwhile; None for the start, or the
            middle of the limits where that is not given either.
        duration: s, about how long; longer where the limits ask for that. None for the usual.
        seed: of what is random.

    Returns:
        time, q, qd, qdd at 100 Hz; from rest to rest, with a continuous acceleration.

    Raises:
        ModelError: no such motion or joint, a joint without room to move, a pose outside the
            limits, or a duration that cannot be.
    """
    if motion not in NEXT_MOTIONS:
        raise ModelError(f"there is no motion '{motion}'; there are {', '.join(NEXT_MOTIONS)}")
    if joint is not None and joint not in joints:
        raise ModelError(f"there is no joint {joint}; there are {', '.join(joints)}")
    if duration is not None and not SHORTEST <= duration <= LONGEST:
        raise ModelError(f"a duration of {duration:g} s: expected {SHORTEST:g} to {LONGEST:g} s")
    held = start if pose is None else pose
    held = _inside(
        "start" if pose is None else "pose",
        limits.middle if held is None else held,
        joints,
        limits,
    )
    first = held if start is None else _inside("start", start, joints, limits)
    path = Path(first, limits)
    number = None if joint is None else list(joints).index(joint)
    free = movable(path)
    if not free or (number is not None and number not in free):
        raise ModelError(
            f"{joint or 'every joint'} has no room to move: its range is a point. Identify the "
            "model from a recording in which it moves"
        )
    chosen = NEXT_MOTIONS[motion]
    path.rest()
    path.move(held)
    path.rest()
    chosen.make(path, number, duration or chosen.usual(len(free) if number is None else 1), seed)
    path.move(first)
    path.rest(REST)
    return path.reference()


def _inside(what: str, values: ArrayLike, joints: Sequence[str], limits: Limits) -> Floats:
    """(N,) rad, found to lie within the limits."""
    pose = np.asarray(values, dtype=np.float64)
    if pose.shape != (len(joints),) or not np.isfinite(pose).all():
        raise ModelError(f"{what}: expected {len(joints)} finite values, one a joint")
    low, high = limits.q_low - _SLACK, limits.q_high + _SLACK
    for n in np.flatnonzero((pose < low) | (pose > high)).tolist():
        raise ModelError(
            f"{what}: {joints[n]} at {pose[n]:.4g} rad lies outside {limits.q_low[n]:.4g} to "
            f"{limits.q_high[n]:.4g} rad"
        )
    return np.clip(pose, limits.q_low, limits.q_high)
