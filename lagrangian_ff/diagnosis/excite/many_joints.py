"""Motions of several joints, one after the other or at once."""

from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from lagrangian_ff.diagnosis.excite.one_joint import strokes_at_two_speeds
from lagrangian_ff.diagnosis.excite.path import REST, Path
from lagrangian_ff.diagnosis.excite.waves import pair, random_wave

Floats = NDArray[np.float64]

ROUND = 12.0
"""s, of the short motion that a warm-up repeats."""
_REACH = 0.8  # of the way from the middle of a pair's motion to the nearer limit
_AT_REST = 1e-6  # rad, a narrower range does not move


def exciting(path: Path, joint: int | None, seconds: float, seed: int) -> None:
    """Every joint through its whole range, slow and fast."""
    path.wave(random_wave(path.at, movable(path), path.limits, seconds, seed), seconds)


def one_by_one(path: Path, joint: int | None, seconds: float, seed: int) -> None:
    """Each joint alone, then pairs with and against each other: all with one, or neighbours."""
    joints = movable(path)
    if joint is None:
        pairs = list(pairwise(joints))
    else:
        pairs = [(joint, other) for other in joints if other != joint]
    # About the pose where it leaves room, the middle of the range otherwise.
    inner = 0.3 * path.limits.width
    centre = np.clip(path.at, path.limits.q_low + inner, path.limits.q_high - inner)
    reach = _REACH * np.minimum(path.limits.q_high - centre, centre - path.limits.q_low)
    path.move(centre)
    parts: list[tuple[int, int | None, float]] = [(n, None, 1.0) for n in joints]
    parts += [(*both, sign) for both in pairs for sign in (1.0, -1.0)]
    share = max(seconds / len(parts) - REST, 1.0)
    for first, second, sign in parts:
        path.wave(pair(path.at, first, second, sign, reach), share)
        path.rest()


def warm_up(path: Path, joint: int | None, seconds: float, seed: int) -> None:
    """The same short motion again and again."""
    joints = movable(path) if joint is None else [joint]
    wave = random_wave(path.at, joints, path.limits, ROUND, seed)
    for _ in range(max(2, round(seconds / (ROUND + REST)))):
        path.wave(wave, ROUND)
        path.rest()


def payloads(path: Path, joint: int | None, seconds: float, seed: int) -> None:
    """All joints at all speeds, then strokes at two speeds under the pose's load."""
    pose = path.at
    path.wave(random_wave(pose, movable(path), path.limits, seconds / 2, seed), seconds / 2)
    joints = movable(path) if joint is None else [joint]
    for n in joints:
        strokes_at_two_speeds(path, n, seconds / 2 / len(joints))
        path.move(pose)


def movable(path: Path) -> list[int]:
    """The joints that have a range."""
    limits = path.limits
    return [
        n
        for n in range(len(path.at))
        if limits.width[n] > _AT_REST and limits.qd_max[n] > 0.0 and limits.qdd_max[n] > 0.0
    ]
