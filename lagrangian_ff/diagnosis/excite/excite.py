"""One of the motions, for these joints and limits."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from lagrangian_ff.arrays import Floats
from lagrangian_ff.diagnosis.excite.motions import NEXT_MOTIONS, movable
from lagrangian_ff.diagnosis.excite.path import REST, Limits, Path, Reference
from lagrangian_ff.errors import ModelError
from lagrangian_ff.identification import Model

SHORTEST, LONGEST = 5.0, 3600.0
"""Ends of what may be asked for as duration, s."""
_SLACK = 1e-9  # rad
_LOOKED_AT = 400
_WAY_COUNTS = 0.3  # a pose at the end of every range must carry this share more of the torque


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
    """Return a motion that shows effects or separates look-alikes.

    Args:
        motion: one of `NEXT_MOTIONS`.  joints: N names.  limits: never left.
        joint: the one to look at; None for all.
        start: (N,) rad, where it begins and ends; None for the pose.
        pose: (N,) rad, where the other joints are held meanwhile; None for the start, or without
            one for the middle of the limits.
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
    what, held = ("start", start) if pose is None else ("pose", pose)
    held = inside(what, limits.middle if held is None else held, joints, limits)
    first = held if start is None else inside("start", start, joints, limits)
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


def inside(what: str, values: ArrayLike, joints: Sequence[str], limits: Limits) -> Floats:
    """Return a pose (N,) in rad after checking that it lies within the limits."""
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


def seen_pose(model: Model, joint: str | None, limits: Limits) -> Floats:
    """Return a pose (N,) in rad of the model's own data: the arm has been there.

    It is the one in which gravity loads the joint most, of poses not far from the middle of the
    ranges; without a joint the one nearest to the middle.
    """
    q = model.data.q[:: max(1, len(model.data) // _LOOKED_AT)]
    q = np.clip(q, limits.q_low, limits.q_high)
    away = np.abs(q - limits.middle) / np.maximum(0.5 * limits.width, 1e-9)
    worth = -away.mean(axis=1)
    if joint is not None:
        n = model.joints.index(joint)
        still = np.zeros_like(q)
        load = np.abs(model.terms(q, still, still).gravity[:, n])
        worth = load / max(float(model.range.tau_max[n]), 1e-9) + _WAY_COUNTS * worth
    return np.asarray(q[int(np.argmax(worth))])
