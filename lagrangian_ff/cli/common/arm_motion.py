"""A motion of the simulated arm that keeps clear of itself, the floor and its torque limits."""

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from functools import partial

import numpy as np

from lagrangian_ff.arm import (
    HOME,
    JOINTS,
    PAPER_LOADS,
    Trajectory,
    check_clearance,
    check_limits,
    limits,
    true_torque,
)
from lagrangian_ff.arm.body import Surroundings
from lagrangian_ff.arrays import Floats
from lagrangian_ff.diagnosis.excite import Limits, excite
from lagrangian_ff.errors import ArmError, UserError
from lagrangian_ff.progress import Progress, silent

REACHES = (1.0, 0.8, 0.6, 0.45, 0.3, 0.2)
"""The shares of the way to the limits that are tried."""
TEMPOS = (1.0, 0.8, 0.6, 0.4)
"""The factors of speed that are tried."""
USED_EFFORT = 0.85
"""The share of the torque limits that a motion may use."""
UNTIL_FAST = 0.3
"""Time in which a joint may reach its highest speed, s: the URDF gives no acceleration."""
_DRAWN, _TRIED = 40, 5  # poses
_REACH = 0.5  # of the range, that poses are drawn from


def clear_motion(
    motion: str,
    joint: str | None,
    start: Floats | None = None,
    duration: float | None = None,
    reach: float = 1.0,
    seed: int = 0,
    progress: Progress = silent,
) -> Trajectory:
    """Return the widest motion that the arm can follow; poses that load the joint come first.

    Args:
        motion: its name.
        joint: the one to look at; None for all.
        start: (6,) rad, where it begins and ends and where the other joints are held; None takes
            home, and poses that load the joint.
        duration: about how long, s.
        reach: the most of the way to the limits that is used, 0 to 1.
        seed: of the random numbers.
        progress: receives the share done, 0 to 1.

    Raises:
        ArmError: none was found that is free of contact and within the torque limits.
        ModelError: see `excite`.
    """
    home = np.array(HOME) if start is None else start
    poses = [home] if start is not None or joint is None else _poses(joint)
    bounds = _limits()
    tries = [(share, pose) for share in REACHES for pose in poses]
    made_by = partial(excite, motion, JOINTS, joint=joint, duration=duration, seed=seed)
    reason = ""
    for number, (share, pose) in enumerate(tries):
        progress(number / len(tries), "looking for a motion free of contact")
        around = bounds.around(pose, reach * share)
        begin = np.clip(home, around.q_low, around.q_high) if start is None else home
        held = pose if start is None else None
        for tempo in TEMPOS:
            made = made_by(around.gentler(tempo), start=begin, pose=held)
            trajectory = Trajectory(made.time, made.q, made.qd, made.qdd, JOINTS)
            if not _too_hard(trajectory):
                break
        else:
            reason = f"its torque exceeds {USED_EFFORT:.0%} of the limits"
            continue
        check_limits(trajectory)
        try:
            check_clearance(trajectory)
            if motion == "payloads":
                check_clearance(trajectory, PAPER_LOADS)
        except ArmError as error:
            reason = str(error)
            continue
        progress(1.0, "looking for a motion free of contact")
        return trajectory
    raise ArmError(
        f"no motion '{motion}' of {joint or ', '.join(JOINTS)} was found that the arm can follow "
        f"from this pose: {reason}; name another start or a smaller --reach"
    )


def _limits() -> Limits:
    arm = limits()
    hardness, effort = arm.velocity / UNTIL_FAST, USED_EFFORT * arm.effort
    whole = Limits(arm.lower, arm.upper, arm.velocity, hardness, tau_max=effort)
    return Limits.within(whole, JOINTS)


def arm_limits(joints: Sequence[str]) -> Limits:
    """Return the limits of the arm.

    Raises:
        UserError: the joints are not those of the arm, in their order.
    """
    _check_joints(joints)
    return _limits()


@contextmanager
def arm_clear(joints: Sequence[str], margin: float) -> Iterator[Callable[[Floats], str]]:
    """Give what says what touches on a path (M, 6) rad of the arm; empty if nothing does.

    Raises:
        UserError: the joints are not those of the arm, in their order.
    """
    _check_joints(joints)
    with Surroundings(margin=margin) as surroundings:

        def touching(path: Floats) -> str:
            return next(filter(None, map(surroundings.first_contact, path)), "")

        yield touching


def _check_joints(joints: Sequence[str]) -> None:
    if tuple(joints) != JOINTS:
        raise UserError(
            f"--arm: the model is of {', '.join(joints)}, the simulated arm has {', '.join(JOINTS)}"
        )


def _poses(joint: str) -> list[Floats]:
    """Return poses, (6,) rad each, in which gravity loads the joint most; home comes last."""
    bounds = limits()
    share = np.random.default_rng(0).uniform(-_REACH, _REACH, (_DRAWN, len(JOINTS)))
    drawn = np.where(share < 0.0, -share * bounds.lower, share * bounds.upper)
    still = np.zeros_like(drawn)
    load = np.abs(true_torque(drawn, still, still, friction=False)[:, JOINTS.index(joint)])
    heaviest = np.argsort(-load, kind="stable")[:_TRIED]
    return [*drawn[heaviest], np.array(HOME)]


def _too_hard(trajectory: Trajectory) -> bool:
    torque = true_torque(trajectory.q[::2], trajectory.qd[::2], trajectory.qdd[::2])
    return bool(np.any(np.abs(torque) > USED_EFFORT * limits().effort))
