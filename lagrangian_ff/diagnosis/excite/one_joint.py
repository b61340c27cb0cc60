"""Motions of one joint, the others held."""

import numpy as np

from lagrangian_ff.diagnosis.excite.path import REST, Path, with_joints
from lagrangian_ff.diagnosis.excite.waves import chirp

CREEP = 0.005
"""rad/s, the slowest speed."""
SWEEP = 0.3
"""rad/s, the fastest slow sweep: 60 periods a turn are then sampled 35 times each at 100 Hz."""
CREEPING = (0.005, 0.015, 0.05, 0.15)
"""rad/s"""
STROKES = (1e-4, 3e-4, 1e-3, 3e-3, 1e-2, 3e-2, 0.15)
"""rad, of the reversals."""
STROKE_SPEEDS = (0.02, 0.1)
"""rad/s, at their middle."""
_SHORTEST_STROKE = 0.25  # s: a servo follows no faster
_LONGEST_STROKE = 1.6  # s at its highest speed
_SHORT, _SHORT_AGAIN = 0.3, 3  # s at its highest speed, and how often a shorter stroke is done
_FEWEST_STROKES = 8
_WIDE = 0.3  # rad, a range that has places
_SPEEDS = 8
_MOST_RUNS = 4


def speeds(path: Path, joint: int, seconds: float) -> None:
    """Runs at constant speeds both ways, from creeping to the limit, evenly spread in log."""
    low, high = path.limits.q_low[joint], path.limits.q_high[joint]
    middle, width = 0.5 * (low + high), high - low
    fastest = min(path.limits.qd_max[joint], np.sqrt(0.4 * path.limits.qdd_max[joint] * width))
    share = seconds / _SPEEDS
    for speed in np.geomspace(min(CREEP, 0.5 * fastest), fastest, _SPEEDS):
        way = min(width, 0.4 * share * speed)
        runs = int(np.clip(share / (2 * (way / speed + REST)), 1, _MOST_RUNS))
        path.move(with_joints(path.at, [(joint, middle - 0.5 * way)]))
        for _ in range(runs):
            _there_and_back(path, joint, way, speed)


def slow_sweep(path: Path, joint: int, seconds: float) -> None:
    """The whole range both ways at one slow constant speed, then creep in its middle."""
    low, high = path.limits.q_low[joint], path.limits.q_high[joint]
    speed = min(SWEEP, 2 * (high - low) / (0.65 * seconds), path.limits.qd_max[joint])
    way = min(high - low, 0.5 * 0.65 * seconds * speed)
    middle = 0.5 * (low + high)
    path.move(with_joints(path.at, [(joint, middle - 0.5 * way)]))
    _there_and_back(path, joint, way, speed)
    path.move(with_joints(path.at, [(joint, middle)]))
    for creep in CREEPING:
        if creep < path.limits.qd_max[joint]:
            short = min(creep * 0.5 * 0.3 * seconds / len(CREEPING), high - middle)
            _there_and_back(path, joint, short, creep)


def reversals(path: Path, joint: int, seconds: float) -> None:
    """Strokes of 0.1 mrad and up at two speeds, in the middle and beside it."""
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
        path.move(with_joints(path.at, [(joint, low + places[number % len(places)] * width)]))
        home = float(path.at[joint])
        for stroke, duration in plan:
            for goal in (home + stroke, home):
                path.move(with_joints(path.at, [(joint, goal)]), duration)
            path.rest()


def _time_of(plan: list[tuple[float, float]]) -> float:
    """s that strokes forth and back take."""
    return sum(2 * duration + REST for _, duration in plan)


def rising(path: Path, joint: int, seconds: float) -> None:
    """Rising frequency at small amplitude, beside the pose where that lies at a limit."""
    low, high = path.limits.q_low[joint], path.limits.q_high[joint]
    inner = 0.15 * (high - low)
    path.move(
        with_joints(path.at, [(joint, float(np.clip(path.at[joint], low + inner, high - inner)))])
    )
    path.wave(chirp(path.at, joint, path.limits, seconds), seconds)


def strokes_at_two_speeds(path: Path, joint: int, seconds: float) -> None:
    """Most of the range both ways, slowly and four times as fast."""
    low, width = path.limits.q_low[joint], path.limits.width[joint]
    way = 0.8 * width
    # Both ways at v and at 4 v take 2.5 way / v.
    slow = min(max(2.5 * way / seconds, CREEP), 0.25 * path.limits.qd_max[joint])
    path.move(with_joints(path.at, [(joint, low + 0.1 * width)]))
    for speed in (slow, 4 * slow):
        _there_and_back(path, joint, way, speed)


def _there_and_back(path: Path, joint: int, way: float, speed: float) -> None:
    begin = float(path.at[joint])
    for goal in (begin + way, begin):
        path.run(joint, goal, speed)
        path.rest()
