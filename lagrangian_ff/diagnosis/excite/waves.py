"""Positions as functions of the share of the time: random, of rising frequency, of two joints."""

from collections.abc import Callable, Sequence

import numpy as np

from lagrangian_ff.arrays import Floats
from lagrangian_ff.diagnosis.excite.path import Limits

Wave = Callable[[Floats], Floats]

FASTEST = 0.6
"""Hz, of a random wave."""
SLOWEST_TEMPO = 0.1
"""A random wave slows down to this part of its highest tempo again and again."""
CHIRP = (0.3, 10.0)
"""Hz, from and to."""
_CHIRP_SIZE = 0.06  # rad, at most, where it is slow
_BREATH = 9.0  # s from one slow stretch to the next, about


def eased(u: Floats) -> Floats:
    """Return 0 to 1 with rest at both ends; 0 before and 1 after."""
    s = np.clip(u, 0.0, 1.0)
    return np.asarray(s**3 * (10.0 - 15.0 * s + 6.0 * s**2))


def random_wave(
    pose: Floats, joints: Sequence[int], limits: Limits, seconds: float, seed: int
) -> Wave:
    """Return a swing of joints between their limits, each at its frequency, slow and fast in turn.

    The swing goes about the middle of the range, eased in from the pose and out to it: every
    position lies between two that the limits allow.
    """
    draw = np.random.default_rng(seed)
    count = len(pose)
    half = 0.5 * limits.width
    # Frequencies at which a full swing would reach 0.8 of the speed or the acceleration allowed.
    room = np.maximum(half, 1e-6)
    top = np.minimum(limits.qd_max / room, np.sqrt(limits.qdd_max / room)) / (2 * np.pi)
    frequency = np.minimum(0.8 * top, FASTEST) * draw.uniform(0.75, 1.0, count)
    phase, sway, swell = draw.uniform(0.0, 2 * np.pi, (3, count))
    breaths = max(2, round(seconds / _BREATH))
    moving = np.zeros(count)
    moving[list(joints)] = 1.0

    def wave(u: Floats) -> Floats:
        # The tempo is lowest at both ends, where the motion is eased in and out.
        turns = 2 * np.pi * breaths * u
        depth = 0.5 * (1.0 - SLOWEST_TEMPO)
        beat = seconds * (u * (1.0 - depth) - depth * np.sin(turns) / (2 * np.pi * breaths))
        angle = 2 * np.pi * frequency * beat[:, None] + phase
        angle += 0.5 * np.sin(0.37 * angle + sway)
        size = 0.7 + 0.3 * np.sin(0.23 * angle + swell)
        target = limits.middle + half * size * np.sin(angle)
        ends = min(0.2, 3.0 / seconds)
        share = (eased(u / ends) * eased((1.0 - u) / ends))[:, None]
        return np.asarray(pose + share * moving * (target - pose))

    return wave


def chirp(pose: Floats, joint: int, limits: Limits, seconds: float) -> Wave:
    """Return a swing of one joint about the pose, ever faster, as small as the limits ask."""
    low, high = CHIRP
    growth = np.log(high / low)
    size = min(_CHIRP_SIZE, 0.1 * float(limits.width[joint]))
    room = min(float(limits.q_high[joint] - pose[joint]), float(pose[joint] - limits.q_low[joint]))
    size = min(size, max(room, 0.0))
    speed, hardness = 0.7 * float(limits.qd_max[joint]), 0.7 * float(limits.qdd_max[joint])

    def wave(u: Floats) -> Floats:
        omega = 2 * np.pi * low * np.exp(growth * u)
        angle = 2 * np.pi * low * seconds * np.expm1(growth * u) / growth
        most = 1.0 / np.sqrt(1.0 / size**2 + (omega / speed) ** 2 + (omega**2 / hardness) ** 2)
        share = eased(u / 0.08) * eased((1.0 - u) / 0.08)
        q = np.tile(pose, (len(u), 1))
        q[:, joint] += share * most * np.sin(angle)
        return q

    return wave


def pair(pose: Floats, first: int, second: int | None, sign: float, reach: Floats) -> Wave:
    """Return one joint forth and back, another with it (sign +1) or against it (-1).

    The two are never in one constant ratio, so that their sum and their difference change sign
    where neither joint does.

    Args:
        pose: (N,) rad, the middle of both.
        first, second: joints; the second may be None.  sign: of the second.
        reach: (N,) rad to both sides.
    """

    def wave(u: Floats) -> Floats:
        angle = 2 * np.pi * eased(u)
        q = np.tile(pose, (len(u), 1))
        q[:, first] += reach[first] * np.sin(angle)
        if second is not None:
            q[:, second] += sign * reach[second] * (np.sin(angle) + 0.5 * np.sin(2 * angle)) / 1.3
        return q

    return wave
