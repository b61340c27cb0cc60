"""Does the torque rest at an extreme while the joint moves?"""

import numpy as np
from numpy.typing import NDArray

from lagrangian_ff.diagnosis.preflight.base import Case, Check

SERIOUS = 0.002
"""Share of the time."""
FLAT = 0.004
"""Of the extreme value: what changes less is at rest."""
LONG = 0.04
"""s that it must rest: the filter's own time."""
_OVERSHOOT = 0.06  # of the extreme: how far the low-pass swings beyond a clipped edge
_MOVED = 0.02  # of the range of velocity: what the joint must move


def check_saturation(case: Case) -> list[Check]:
    """Stretches in which the measured torque stays at its largest or smallest value."""
    found = []
    for n, name in enumerate(case.joints):
        for sign in (1.0, -1.0):
            rest = _resting(case, n, sign)
            if rest is None:
                continue
            level, share, first = rest
            found.append(
                Check(
                    "saturation",
                    name,
                    f"the effort of {name} rests at {level:.4g} N·m for {share:.1%} of the time, "
                    f"first at {first:.2f} s: a limit cuts it",
                    share >= SERIOUS,
                    "Repeat the motion slower or without payload, so that no torque reaches the "
                    "limit; or add the effect saturation",
                    {"level": level, "share": share, "first": first},
                )
            )
    return found


def _resting(case: Case, n: int, sign: float) -> tuple[float, float, float] | None:
    """N·m, share of the time and s of the first, where it rests at an extreme."""
    motion = case.motion
    tau = sign * motion.tau[:, n]
    top, middle = float(tau.max()), float(np.median(tau))
    room = top - middle
    near = np.flatnonzero(tau > top - _OVERSHOOT * room)
    if room <= 0.0 or not near.size:
        return None
    # Runs of samples that lie within FLAT of the value in their middle.
    runs = _runs(tau, near, FLAT * room)
    moving = _MOVED * float(np.abs(motion.qd[:, n]).max())
    long = []
    for begin, end in runs:
        seconds = float(motion.time[end] - motion.time[begin])
        whole = motion.segment[begin] == motion.segment[end]
        if whole and seconds >= LONG and np.abs(motion.qd[begin : end + 1, n]).max() > moving:
            long.append((begin, end, float(np.median(tau[begin : end + 1]))))
    if not long:
        return None
    # A limit is one level: that at which it rests longest.
    level = max(long, key=lambda run: run[1] - run[0])[2]
    same = [(a, b) for a, b, value in long if abs(value - level) <= 2 * FLAT * room]
    samples = sum(b - a + 1 for a, b in same)
    if not _unusual(tau, level, samples, FLAT * room):
        return None
    return sign * level, samples / len(tau), float(motion.time[same[0][0]])


def _runs(tau: NDArray[np.float64], near: NDArray[np.int64], width: float) -> list[tuple[int, int]]:
    """First and last samples of stretches near the top that stay within a width."""
    runs = []
    begin = last = int(near[0])
    low = high = float(tau[begin])
    for k in near[1:].tolist():
        value = float(tau[k])
        low, high = min(low, value), max(high, value)
        if k != last + 1 or high - low > width:
            runs.append((begin, last))
            begin, low, high = k, value, value
        last = k
    runs.append((begin, last))
    return runs


def _unusual(tau: NDArray[np.float64], level: float, samples: int, width: float) -> bool:
    """Whether far more samples lie at the level than in bands as wide below it."""
    below = [
        np.count_nonzero((tau > level - (k + 1.5) * width) & (tau <= level - (k + 0.5) * width))
        for k in range(1, 5)
    ]
    return samples > 4 * max(1.0, float(np.mean(below)))
