"""A motion as it is sent: first slowly to its start, and along its own path to a stop."""

from dataclasses import dataclass

import numpy as np

from lagrangian_ff.arm.trajectory import Trajectory
from lagrangian_ff.arrays import Floats
from lagrangian_ff.errors import UserError

SLOWEST, FASTEST = 0.05, 0.3
"""rad/s, or m/s of joints that slide: bounds of the highest speed on the way to the start."""
SHARE = 0.5
"""Share of a joint's own highest speed in the motion that the way to its start may reach."""
SHORTEST = 1.0  # s that the way to the start takes at least
PEAK = 15.0 / 8.0
"""Highest speed of a minimum-jerk move, in units of its mean speed (Flash and Hogan 1985, (8))."""
RESTING = 0.02  # rad/s at the ends of a motion that begins and ends at rest
STEP = 0.01  # s between the samples that speeds are read from
STOPPING = 0.5  # s
POINTS = 26


@dataclass(frozen=True)
class Plan:
    """A motion with the way to its start before it.

    Attributes:
        trajectory: all that is sent; time begins at 0.
        way: s of it that lead to the start.
        moved: (N,) rad by which the way moves each joint.
        fastest: (N,) rad/s, the highest speed of each joint in the motion.
    """

    trajectory: Trajectory
    way: float
    moved: Floats
    fastest: Floats


def plan(motion: Trajectory, q: Floats) -> Plan:
    """Return a motion with a slow minimum-jerk move from a pose to its start before it.

    Args:
        motion: at least two points, at rest at both ends.
        q: (N,) rad, where the arm stands, in the order of the motion's joints.

    Raises:
        UserError: the motion has one point only, or does not begin and end at rest.
    """
    if len(motion) < 2:
        raise UserError("the motion has one point only: expected a path of two or more")
    for end, words in ((0, "begin"), (-1, "end")):
        speed = np.abs(motion.qd[end])
        n = int(np.argmax(speed))
        if speed[n] > RESTING:
            raise UserError(
                f"the motion does not {words} at rest: {motion.joints[n]} moves at "
                f"{speed[n]:.2g} rad/s there"
            )
    moved = motion.q[0] - q
    fine = np.linspace(motion.time[0], motion.time[-1], max(2, int(motion.duration / STEP)))
    fastest = np.abs(motion.sample(fine)[1]).max(axis=0)
    allowed = np.clip(SHARE * fastest, SLOWEST, FASTEST)
    way = max(SHORTEST, float(np.max(PEAK * np.abs(moved) / allowed)))
    still = np.zeros((1, len(motion.joints)))
    trajectory = Trajectory(
        np.concatenate([[0.0], way + motion.time - motion.time[0]]),
        np.concatenate([q[None], motion.q]),
        np.concatenate([still, motion.qd]),
        np.concatenate([still, motion.qdd]),
        motion.joints,
    )
    return Plan(trajectory, way, moved, fastest)


def slowed(trajectory: Trajectory, at: float) -> Trajectory:
    """Return how a motion comes to rest from a time on, without leaving its path.

    The path is followed ever slower: its speed falls to zero as 1 - 3x² + 2x³.

    Args:
        at: s since the motion began.
    """
    u = np.linspace(0.0, STOPPING, POINTS)
    x = u / STOPPING
    since = at + STOPPING * (x - x**3 + 0.5 * x**4)
    rate, change = (1.0 - 3.0 * x**2 + 2.0 * x**3)[:, None], (-6.0 * x * (1.0 - x))[:, None]
    q, qd, qdd = trajectory.sample(trajectory.time[0] + since)
    return Trajectory(u, q, qd * rate, qdd * rate**2 + qd * change / STOPPING, trajectory.joints)


def held(joints: tuple[str, ...], q: Floats) -> Trajectory:
    """Return the motion that stays at a pose (N,) rad."""
    still = np.zeros((2, len(joints)))
    return Trajectory(np.array([0.0, STOPPING]), np.stack([q, q]), still, still, joints)
