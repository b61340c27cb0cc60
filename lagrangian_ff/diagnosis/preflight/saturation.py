"""Does the torque rest at an extreme while the joint moves?"""

import numpy as np
from numpy.typing import NDArray

from lagrangian_ff.diagnosis.preflight.base import Case, Check, rate_of

Floats = NDArray[np.float64]

SHARE = 0.002
"""Of the time, that it must rest."""
PILED = 0.7
"""Share of the samples in the highest four bands that one band holds: half of a round peak's."""
FLAT = 0.004
"""Of the extreme value: what changes less stands still."""
LONG = 0.04
"""s that it must stand still: the filter's own time."""
VARIES = 0.025
"""Of the extreme value: what the model's torque must change meanwhile."""
_RINGING = 0.06  # of the extreme: how far the low-pass swings beyond a clipped edge
_BAND = 0.006  # of the torque's range above its median, at least
_NOISE = 4.0  # times the noise, at least
_OVERSHOOT = 0.1  # of that range: how far noise and the low-pass swing beyond a clipped edge
_FEWEST = 8  # samples
_MOVED = 0.02  # of the top speed: what the joint must move
_FLAT = 1.5  # times the spread of the torque there: what the model's must vary
_LEVELS = 60  # that are tried


def check_saturation(case: Case) -> list[Check]:
    """Whether the measured torque stays at its largest or smallest value."""
    found = []
    for n, name in enumerate(case.joints):
        for sign in (1.0, -1.0):
            rest = _flat(case, n, sign) or _piled_up(case, n, sign)
            if rest is None:
                continue
            level, share, first = rest
            found.append(
                Check(
                    "saturation",
                    name,
                    f"the effort of {name} rests at {level:.4g} N·m for {share:.1%} of the time, "
                    f"first at {first:.2f} s: a limit cuts it",
                    True,
                    "Repeat the motion slower or without payload, so that no torque reaches the "
                    "limit; or add the effect saturation",
                    {"level": level, "share": share, "first": first},
                )
            )
    return found


def _flat(case: Case, n: int, sign: float) -> tuple[float, float, float] | None:
    """Where a torque without noise stands still, as the driver cut it."""
    motion = case.motion
    tau = sign * motion.tau[:, n]
    top, middle = float(tau.max()), float(np.median(tau))
    room = top - middle
    near = np.flatnonzero(tau > top - _RINGING * room)
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
    if samples < SHARE * len(tau) or not _unusual(tau, level, samples, FLAT * room):
        return None
    expected = np.interp(motion.time, case.thin.time, case.slope[n] * case.predicted[:, n])
    if np.mean([np.ptp(expected[a : b + 1]) for a, b in same]) < VARIES * room:
        # The model's torque rests there too: a slow round peak.
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


def _piled_up(case: Case, n: int, sign: float) -> tuple[float, float, float] | None:
    """Where a noisy torque piles up: in a band as wide as its noise, where the model's varies."""
    motion = case.thin
    speed = np.abs(motion.qd[:, n])
    moving = speed > _MOVED * float(speed.max())
    tau = sign * motion.tau[:, n]
    if moving.sum() < 10 * _FEWEST:
        return None
    top, room = float(tau[moving].max()), float(np.ptp(tau[moving]))
    room = min(room, top - float(np.median(tau[moving])))
    if room <= 0.0:
        return None
    width = max(_BAND * room, _NOISE * _noise(tau, rate_of(motion)))
    level = _piled(np.sort(tau[moving]), top, room, width)
    if level is None:
        return None
    resting = moving & (np.abs(tau - level) <= 0.5 * width)
    stretches = np.count_nonzero(np.diff(resting.astype(np.int8)) == 1)
    if resting.sum() < 1.5 * LONG * rate_of(motion) * stretches:
        # Round peaks, if of one height.
        return None
    expected = case.slope[n] * case.predicted[resting, n]
    if float(np.std(expected)) < _FLAT * float(np.std(tau[resting])):
        return None
    level = float(np.median(tau[resting]))
    return sign * level, float(resting.mean()), float(motion.time[int(np.argmax(resting))])


def _piled(ordered: Floats, top: float, room: float, width: float) -> float | None:
    """The level whose band holds most of what lies above four bands below; None where none does."""
    levels = np.linspace(top - _OVERSHOOT * room - width, top, _LEVELS)
    count = len(ordered)
    inside = np.searchsorted(ordered, levels + 0.5 * width, "right") - np.searchsorted(
        ordered, levels - 0.5 * width
    )
    above = count - np.searchsorted(ordered, levels - 3.5 * width)
    enough = inside >= max(_FEWEST, SHARE * count)
    if not enough.any():
        return None
    share = np.where(enough, inside / np.maximum(above, 1), 0.0)
    best = int(np.argmax(share))
    return float(levels[best]) if share[best] > PILED else None


def _noise(tau: Floats, rate: float) -> float:
    """N·m, the deviation of what changes within 20 ms: third differences, of steps few."""
    apart = max(1, round(0.02 * rate))
    third = np.diff(np.stack([tau[k * apart : len(tau) - (3 - k) * apart] for k in range(4)]), 3, 0)
    return float(1.4826 * np.median(np.abs(third)) / np.sqrt(20.0))
