"""The motions, listed once by the names that effects give them."""

from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from lagrangian_ff.diagnosis.excite.path import REST, Path
from lagrangian_ff.diagnosis.excite.waves import chirp, pair, random_wave

CREEP = 0.005
"""The slowest speed, rad/s."""
SWEEP = 0.3
"""The fastest slow sweep, rad/s: 60 periods a turn are then sampled 35 times each at 100 Hz."""
CREEPING = (0.005, 0.015, 0.05, 0.15)
"""Speeds at which a joint creeps, rad/s."""
STROKES = (1e-4, 3e-4, 1e-3, 3e-3, 1e-2, 3e-2, 0.15)
"""Strokes of the reversals, rad."""
STROKE_SPEEDS = (0.02, 0.1)
"""Speeds at the middle of a stroke, rad/s."""
_SHORTEST_STROKE = 0.25  # s: a servo follows no faster
_LONGEST_STROKE = 1.6  # s at its highest speed
_SHORT, _SHORT_AGAIN = 0.3, 3  # s at its highest speed, and how often a shorter stroke is done
_FEWEST_STROKES = 8
_WIDE = 0.3  # rad, a range that has places
_SPEEDS = 8
_MOST_RUNS = 4
ROUND = 12.0
"""Duration of the short motion that a warm-up repeats, s."""
_REACH = 0.8  # of the way from the middle of a pair's motion to the nearer limit
_AT_REST = 1e-6  # rad, a narrower range does not move

Maker = Callable[[Path, int | None, float, int], None]
"""(path, joint, seconds, seed): appends the motion of a joint, or of all if None, to the path."""


def speeds(path: Path, joint: int, seconds: float) -> None:
    """Append runs at constant speeds both ways, in equal ratios from creeping to the limit."""
    middle, width = path.limits.middle[joint], path.limits.width[joint]
    fastest = min(path.limits.qd_max[joint], np.sqrt(0.4 * path.limits.qdd_max[joint] * width))
    share = seconds / _SPEEDS
    for speed in np.geomspace(min(CREEP, 0.5 * fastest), fastest, _SPEEDS):
        way = min(width, 0.4 * share * speed)
        runs = int(np.clip(share / (2 * (way / speed + REST)), 1, _MOST_RUNS))
        path.move_joint(joint, middle - 0.5 * way)
        for _ in range(runs):
            there_and_back(path, joint, way, speed)


def slow_sweep(path: Path, joint: int, seconds: float) -> None:
    """Append the whole range both ways at one slow constant speed, then creep in its middle."""
    low, high = path.limits.q_low[joint], path.limits.q_high[joint]
    speed = min(SWEEP, 2 * (high - low) / (0.65 * seconds), path.limits.qd_max[joint])
    way = min(high - low, 0.5 * 0.65 * seconds * speed)
    middle = 0.5 * (low + high)
    path.move_joint(joint, middle - 0.5 * way)
    there_and_back(path, joint, way, speed)
    path.move_joint(joint, middle)
    for creep in CREEPING:
        if creep < path.limits.qd_max[joint]:
            short = min(creep * 0.5 * 0.3 * seconds / len(CREEPING), high - middle)
            there_and_back(path, joint, short, creep)


def reversals(path: Path, joint: int, seconds: float) -> None:
    """Append strokes of 0.1 mrad and up at two speeds, in the middle and beside it."""
    low, width = path.limits.q_low[joint], path.limits.width[joint]
    plan = [
        (stroke, max(1.875 * stroke / speed, _SHORTEST_STROKE))
        for speed in STROKE_SPEEDS
        for stroke in STROKES
        if stroke <= 0.3 * width and stroke <= _LONGEST_STROKE * speed
        for _ in range(_SHORT_AGAIN if stroke <= _SHORT * speed else 1)
    ]
    while len(plan) > _FEWEST_STROKES and _time_of(plan) > seconds:
        plan.remove(max(plan, key=lambda stroke: stroke[1]))
    places = (0.5, 0.3, 0.7) if width > _WIDE else (0.5,)
    for number in range(max(1, round(seconds / _time_of(plan)))):
        path.move_joint(joint, low + places[number % len(places)] * width)
        home = float(path.at[joint])
        for stroke, duration in plan:
            for goal in (home + stroke, home):
                path.move_joint(joint, goal, duration)
            path.rest()


def _time_of(plan: list[tuple[float, float]]) -> float:
    """Return the time in s that strokes forth and back take."""
    return sum(2 * duration + REST for _, duration in plan)


def rising(path: Path, joint: int, seconds: float) -> None:
    """Append a rising frequency at small amplitude, beside the pose if that lies at a limit."""
    low, high = path.limits.q_low[joint], path.limits.q_high[joint]
    inner = 0.15 * (high - low)
    path.move_joint(joint, float(np.clip(path.at[joint], low + inner, high - inner)))
    path.wave(chirp(path.at, joint, path.limits, seconds), seconds)


def strokes_at_two_speeds(path: Path, joint: int, seconds: float) -> None:
    """Append most of the range both ways, slowly and four times as fast."""
    low, width = path.limits.q_low[joint], path.limits.width[joint]
    way = 0.8 * width
    # Both ways at v and at 4 v take 2.5 way / v.
    slow = min(max(2.5 * way / seconds, CREEP), 0.25 * path.limits.qd_max[joint])
    path.move_joint(joint, low + 0.1 * width)
    for speed in (slow, 4 * slow):
        there_and_back(path, joint, way, speed)


def there_and_back(path: Path, joint: int, way: float, speed: float) -> None:
    """Append a run at a constant speed and one back, with a rest after each."""
    begin = float(path.at[joint])
    for goal in (begin + way, begin):
        path.run(joint, goal, speed)
        path.rest()


def exciting(path: Path, joint: int | None, seconds: float, seed: int) -> None:
    """Append a swing of every joint through its whole range, slow and fast."""
    path.wave(random_wave(path.at, movable(path), path.limits, seconds, seed), seconds)


def one_by_one(path: Path, joint: int | None, seconds: float, seed: int) -> None:
    """Append each joint alone, then pairs of neighbours or of all with one, both ways."""
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
    """Append the same short motion again and again."""
    joints = movable(path) if joint is None else [joint]
    wave = random_wave(path.at, joints, path.limits, ROUND, seed)
    for _ in range(max(2, round(seconds / (ROUND + REST)))):
        path.wave(wave, ROUND)
        path.rest()


def payloads(path: Path, joint: int | None, seconds: float, seed: int) -> None:
    """Append all joints at all speeds, then strokes at two speeds under the pose's load."""
    pose = path.at
    exciting(path, joint, seconds / 2, seed)
    joints = movable(path) if joint is None else [joint]
    for n in joints:
        strokes_at_two_speeds(path, n, seconds / 2 / len(joints))
        path.move(pose)


def movable(path: Path) -> list[int]:
    """Return the joints that have room to move."""
    limits = path.limits
    free = (limits.width > _AT_REST) & (limits.qd_max > 0.0) & (limits.qdd_max > 0.0)
    return [int(n) for n in np.flatnonzero(free)]


@dataclass(frozen=True)
class NextMotion:
    """A motion that shows effects or separates look-alikes.

    Attributes:
        make: appends it to a path.
        seconds: how long it should last for one joint, or for all where all move at once.
        meaning: what it is and what it shows.
        one_each: whether all joints do it one after the other, half as long each.
        by_hand: what the user must do.
    """

    make: Maker
    seconds: float
    meaning: str
    one_each: bool = False
    by_hand: str = "Record joint states from a second before it begins to a second after its end."

    def usual(self, joints: int) -> float:
        """Return the time in s that it should last for this many joints."""
        return self.seconds * max(1.0, 0.5 * joints) if self.one_each else self.seconds


def _each(one: Callable[[Path, int, float], None], usual: float, meaning: str) -> NextMotion:
    """Return the motion of one joint, or of all one after the other, each from the pose."""

    def make(path: Path, joint: int | None, seconds: float, seed: int) -> None:
        pose = path.at
        joints = movable(path) if joint is None else [joint]
        for n in joints:
            one(path, n, seconds / len(joints))
            path.move(pose)
            path.rest(REST)

    return NextMotion(make, usual, meaning, one_each=True)


NEXT_MOTIONS: dict[str, NextMotion] = {
    "exciting": NextMotion(
        exciting,
        60.0,
        "All joints swing through their ranges at once, slow and fast in turn. It shows inertia, "
        "gravity and their couplings, and is what a model is best identified from.",
    ),
    "speeds": _each(
        speeds,
        60.0,
        "One joint runs both ways at constant speeds from creeping to its limit. It shows how "
        "friction depends on speed: viscous, quadratic, a power, unequal both ways.",
    ),
    "slow sweep": _each(
        slow_sweep,
        60.0,
        "One joint goes slowly through its whole range and back, then creeps at 0.005 to "
        "0.15 rad/s. It shows what depends on position (ripple, springs, worn places) without "
        "inertia, and the friction of creeping.",
    ),
    "reversals": _each(
        reversals,
        60.0,
        "One joint reverses again and again, with strokes of 0.1 mrad to 0.15 rad at two speeds. "
        "It separates dry friction, hysteresis before sliding, and backlash.",
    ),
    "chirp": _each(
        rising,
        40.0,
        "One joint trembles by a few mrad, from 0.3 to 10 Hz. It separates a delay (grows with the "
        "frequency) from elasticity (grows with its square).",
    ),
    "one by one": NextMotion(
        one_by_one,
        80.0,
        "Each joint moves alone, then pairs of them, with and against each other. It shows "
        "friction in shared gears, which a joint alone cannot.",
    ),
    "warm-up": NextMotion(
        warm_up,
        300.0,
        "The same short motion again and again. Friction changes as the gears get warm, gravity "
        "does not.",
        by_hand="Let the arm stand until it is cold, then record the whole motion without a pause.",
    ),
    "payloads": NextMotion(
        payloads,
        60.0,
        "One motion to be done twice, at all speeds and with slow strokes. What follows the load "
        "differs between the two.",
        by_hand="Record it once as the arm is, then fix a payload of known mass to the last link "
        "and record it again: two recordings. Check before the second that the payload clears "
        "everything.",
    ),
}
"""Every motion by its name; the names are those of `lagrangian_ff.effects.MOTIONS`."""
