"""Motions through the whole workspace at ten speeds, to identify the arm from (section IV-B)."""

from collections.abc import Sequence

import numpy as np
import scipy

from lagrangian_ff.arm.body import Surroundings
from lagrangian_ff.arm.description import HOME, JOINTS, PAPER_LOADS, limits
from lagrangian_ff.arm.plant import Plant
from lagrangian_ff.arm.trajectory import Trajectory
from lagrangian_ff.arrays import Floats
from lagrangian_ff.errors import ArmError

SPEEDS = range(1, 11)
MEAN_NORM = 0.38  # rad/s of mean velocity norm for each speed number
DURATION, SHORTEST, LONGEST = 35.0, 30.0, 40.0  # s
GRID = 0.01  # s, the spacing of the points
MARGIN = 0.02  # m, kept from the floor and between links
CHECK = 4  # points; every fourth is checked for collisions
REACH = 0.85  # share of the joint ranges that via points are drawn from
USED_VELOCITY, USED_EFFORT, USED_RANGE = 0.95, 0.85, 0.98
REPAIRS = 300
BLOCK = 4


def exciting_trajectory(speed: int = 5, seed: int = 0, duration: float | None = None) -> Trajectory:
    """Return a quintic spline (C⁴) through random via points, from home at rest to home at rest.

    Every stretch of four via points draws each joint once from every quarter of its range, so
    that the workspace is covered early. Via points beside which the motion would leave 95 % of
    the velocity limits or 85 % of the torque limits (the plant's true torques, with and without
    the paper's loads), or come within 2 cm of the floor or of another link (loads included), are
    drawn again.

    Args:
        speed: 1 to 10; the mean norm of velocity rises with it, by 0.38 rad/s each.
        seed: the same seed, speed and duration give the same motion.
        duration: s; None for what gives that mean velocity, 30 to 40 s.

    Returns:
        Points every 10 ms.

    Raises:
        ArmError: no such speed or seed, a duration below 4 s, or no admissible motion was found.
    """
    if not isinstance(speed, int | np.integer) or speed not in SPEEDS:
        raise ArmError(f"speed: expected a whole number from 1 to {SPEEDS[-1]}, got {speed!r}")
    if not isinstance(seed, int | np.integer) or seed < 0:
        raise ArmError(f"seed: expected a whole number from 0 up, got {seed!r}")
    if duration is not None and not (np.isfinite(duration) and duration >= 4.0):
        raise ArmError(f"duration: expected at least 4 s, got {duration!r}")
    random = np.random.default_rng([seed, speed])
    vias = _via_points(random, MEAN_NORM * speed * (duration or DURATION))
    plants = [Plant(loads=loads) for loads in (None, PAPER_LOADS)]
    try:
        with Surroundings(PAPER_LOADS, margin=MARGIN) as surroundings:
            for _ in range(REPAIRS):
                times = _times(vias, duration or DURATION)
                trajectory = _sampled(times, vias)
                if duration is None:
                    norm = float(np.linalg.norm(trajectory.qd, axis=1).mean())
                    ratio = norm / (MEAN_NORM * speed)
                    times = _times(vias, float(np.clip(DURATION * ratio, SHORTEST, LONGEST)))
                    trajectory = _sampled(times, vias)
                failures = failed_checks(trajectory, plants, surroundings)
                if not len(failures):
                    return trajectory
                _replace(vias, times, failures, random)
    finally:
        for plant in plants:
            plant.close()
    raise ArmError(
        f"no motion of speed {speed} within limits and free of collision was found from seed "
        f"{seed}; try another seed, a lower speed or a longer duration"
    )


def usable_range() -> tuple[Floats, Floats]:
    """Return the ends of the part of each joint's range that poses are drawn from, (6,) rad."""
    bounds = limits()
    return REACH * bounds.lower, REACH * bounds.upper


def _via_points(random: np.random.Generator, path: float) -> Floats:
    """Return home, enough via points for the path's length in rad, and home: (K, 6) rad."""
    low, high = usable_range()
    vias = [np.array(HOME)]
    length, goal = 0.0, max(path, 6.0)
    while length < goal:
        strata = np.stack([random.permutation(BLOCK) for _ in JOINTS], axis=1)
        for row in strata:
            share = (row + random.uniform(size=len(JOINTS))) / BLOCK
            vias.append(low + share * (high - low))
            length += float(np.linalg.norm(vias[-1] - vias[-2]))
            if length + float(np.linalg.norm(vias[-1] - vias[0])) >= goal:
                return np.array([*vias, vias[0]])
    return np.array([*vias, vias[0]])


def _times(vias: Floats, duration: float) -> Floats:
    """Return the time of each via point, (K,) s on the grid, by the distances between them."""
    steps = np.abs(np.diff(vias, axis=0))
    weight = np.max(steps / limits().velocity, axis=1) + 0.3 * np.linalg.norm(steps, axis=1)
    # From rest and to rest the arm needs longer.
    weight[[0, -1]] *= 1.4
    weight = np.maximum(weight, 0.35 * weight.mean())
    times = np.concatenate([[0.0], np.cumsum(weight)]) / weight.sum() * duration
    return np.round(times / GRID) * GRID


def _sampled(times: Floats, vias: Floats) -> Trajectory:
    still = np.zeros(len(JOINTS))
    rest = [(1, still), (2, still)]
    spline = scipy.interpolate.make_interp_spline(times, vias, k=5, bc_type=(rest, rest))
    time = np.arange(round(times[-1] / GRID) + 1) * GRID
    return Trajectory(time, spline(time), spline(time, 1), spline(time, 2))


def failed_checks(
    trajectory: Trajectory, plants: Sequence[Plant], surroundings: Surroundings
) -> Floats:
    """Return the times of failed checks; the cheap checks come first."""
    bounds = limits()
    q, qd, qdd = trajectory.q, trajectory.qd, trajectory.qdd
    amiss = np.any(
        (q < USED_RANGE * bounds.lower)
        | (q > USED_RANGE * bounds.upper)
        | (np.abs(qd) > USED_VELOCITY * bounds.velocity),
        axis=1,
    )
    if not amiss.any():
        for plant in plants:
            torque = plant.true_torque(q[::2], qd[::2], qdd[::2])
            amiss[::2] |= np.any(np.abs(torque) > USED_EFFORT * bounds.effort, axis=1)
    if not amiss.any():
        for k in range(0, len(trajectory), CHECK):
            amiss[k] = surroundings.first_contact(q[k]) is not None
    return trajectory.time[amiss]


def _replace(vias: Floats, times: Floats, failures: Floats, random: np.random.Generator) -> None:
    """Draw the inner via points nearest to the failures again."""
    low, high = usable_range()
    nearest = np.argmin(np.abs(failures[:, None] - times[None, 1:-1]), axis=1) + 1
    for k in np.unique(nearest):
        vias[k] = random.uniform(low, high)
