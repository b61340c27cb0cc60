"""A clock that stepped while the arm was recorded: where, by how much, and what time passed.

A clock that is set (NTP, a restarted simulation) moves all later stamps by the same amount. A pause
in which samples were lost looks the same in the stamps, but not in the motion: the joints went on
moving. Where position, velocity and acceleration go on as if only a few periods had passed, and
would not if more had, the clock stepped. Polynomials of several degrees follow the motion on both
sides, and what they cost says how much time passed.
"""

from dataclasses import dataclass

import numpy as np

from lagrangian_ff.arrays import Floats, Ints
from lagrangian_ff.recording.stamps import RESET, least_distance

_SMALLEST = 6e-3  # s; smaller steps are taken for late stamps
_FEWEST = 10  # samples that must be on each side
_BESIDE = 20  # samples of a side by which a lasting step is told from late stamps
_SPAN = 0.06  # s, of the motion on each side
_LONGEST = 40  # samples of these
_ROOM = 0.1  # s; over a longer pause motion cannot be extended
_MOST = 10  # periods that may have passed unseen
_CERTAIN = 15.0  # log likelihood by which other times must be worse
_ALIKE = 2.0  # times the noise that may be left where the motion goes on
_SIDE = 4  # degree of the polynomial that follows the motion on one side
_DEGREES = (3, 5, 7, 9)  # of one that follows it on both
_NOISE = 5.0  # times the jitter that a step must exceed


@dataclass(frozen=True)
class Step:
    """A step of the clock.

    Attributes:
        at: the first sample after it.
        size: s, by which the clock was set forward; negative where it was set back.
        joined: whether the motion shows how much time passed; if not, what follows is apart.
    """

    at: int
    size: float
    joined: bool


def without_steps(time: Floats, position: Floats) -> tuple[Floats, list[Step]]:
    """Return stamps of a clock that never stepped, and the steps.

    Args:
        time: (K,) s, in order of arrival.
        position: (K, N) rad.
    """
    time = time.copy()
    found = []
    lasting = _lasting(time)
    coarse = least_distance(position) if lasting else np.zeros(position.shape[1])
    pauses = np.diff(time)
    for at in lasting:
        pause = float(pauses[at - 1])
        passed = _passed(time, position, at, coarse)
        if passed is not None:
            found.append(Step(at, pause - passed, True))
            time[at:] -= pause - passed
        elif pause < 0:
            found.append(Step(at, pause, False))
            time[at:] += time[:at].max() + RESET - time[at:].min()
    return time, found


def _lasting(time: Floats) -> list[int]:
    """Return the samples from which on all stamps are shifted."""
    step = np.diff(time)
    if len(step) < 2 * _FEWEST or not (step > 0).any():
        return []
    wide = min(50, len(step))
    usual = float(np.median((time[wide:] - time[:-wide]) / wide))
    last = np.flatnonzero((step < 0) | (step > max(_SMALLEST, 1.75 * usual)))
    last = last[(last >= _FEWEST - 1) & (last + _FEWEST < len(time))]
    if last.size == 0:
        return []
    near = np.arange(_BESIDE)
    before = last[:, np.newaxis] - near
    after = last[:, np.newaxis] + 1 + near
    left, left_slope, left_noise = _lines(time, before, -0.5)
    right, right_slope, right_noise = _lines(time, after, -0.5)
    noise = np.maximum(left_noise, right_noise)
    jump = right - left
    slow, fast = np.minimum(-left_slope, right_slope), np.maximum(-left_slope, right_slope)
    real = (np.abs(jump) > np.maximum(_SMALLEST, _NOISE * noise)) & (slow > 0.5 * fast)
    real &= slow > 0.5 * usual
    found: list[int] = []
    for at in last[real][np.argsort(-np.abs(jump[real]), kind="stable")] + 1:
        if all(abs(at - other) >= _FEWEST for other in found):
            found.append(int(at))
    return sorted(found)


def _lines(time: Floats, index: Ints, to: float) -> tuple[Floats, Floats, Floats]:
    """Return value at `to`, slope and noise of lines through the stamps at indices (C, W)."""
    there = (index >= 0) & (index < len(time))
    stamps = time[np.clip(index, 0, len(time) - 1)]
    origin = stamps[:, :1]
    stamps = np.where(there, stamps - origin, 0.0)
    place = np.where(there, np.arange(index.shape[1], dtype=np.float64), 0.0)
    count = there.sum(axis=1)
    middle, level = place.sum(axis=1) / count, stamps.sum(axis=1) / count
    off = np.where(there, place - middle[:, np.newaxis], 0.0)
    slope = (off * stamps).sum(axis=1) / (off**2).sum(axis=1)
    left = stamps - level[:, np.newaxis] - slope[:, np.newaxis] * off
    noise = np.sqrt(np.where(there, left**2, 0.0).sum(axis=1) / (count - 2))
    return origin[:, 0] + level + slope * (to - middle), slope, noise


def _passed(time: Floats, position: Floats, at: int, coarse: Floats) -> float | None:
    """Return the time that passed before a sample by its motion, s; None if it agrees with the
    stamps or does not show.

    Args:
        coarse: (N,) rad, the least distance of two positions of a joint.
    """
    sides = []
    for rows in (np.arange(at - 1, -1, -1), np.arange(at, len(time))):
        rows = rows[:_LONGEST]
        away = np.abs(time[rows] - time[rows[0]])
        breaks = np.flatnonzero(np.abs(np.diff(time[rows])) > _SPAN)
        inside = len(rows) if breaks.size == 0 else int(breaks[0]) + 1
        rows = rows[:inside]
        rows = rows[: max(_FEWEST, int(np.searchsorted(away[:inside], _SPAN)))]
        if len(rows) < _FEWEST:
            return None
        sides.append(rows)
    before, after = time[sides[0]] - time[at - 1], time[sides[1]] - time[at]
    values = [position[rows] - position[at - 1] for rows in sides]
    both = np.concatenate(values)
    period = float(np.median(np.abs(np.concatenate([np.diff(before), np.diff(after)]))))
    apart = sum(_left(x, y, _SIDE) for x, y in zip((before, after), values, strict=True))
    # A slow joint stays on a step of its encoder for some samples, which err alike.
    change = np.mean(np.abs(np.concatenate([np.diff(one, axis=0) for one in values])), axis=0)
    alike = np.minimum(coarse / np.maximum(change, 1e-12), len(both))
    least = coarse**2 / 12.0 * (1.0 + alike) + 1e-24
    noise = np.maximum(apart / (len(both) - 2 * (_SIDE + 1)), least)
    scale = max(abs(before[-1]), after[-1])
    moving = np.count_nonzero(np.ptp(both, axis=0) > 0)

    def cost(passed: float) -> float:
        """Return the cost of the polynomial that pays best, its coefficients included."""
        x = np.concatenate([before, after + passed]) / scale
        return min(
            float(np.sum(_left(x, both, degree) / noise)) / 2
            + moving * degree * np.log(len(both)) / 2
            for degree in _DEGREES
        )

    if not period > 0:
        return None
    guesses = period * np.arange(1, _MOST + 1)
    costs = np.array([cost(guess) for guess in guesses])
    best = int(np.argmin(costs))
    moved = costs[np.abs(np.arange(_MOST) - best) >= 3]
    expected = moving * (len(both) + _DEGREES[0] * np.log(len(both))) / 2
    if expected == 0 or costs[best] > _ALIKE * expected or best == _MOST - 1:
        return None
    unlike = _CERTAIN * max(1.0, costs[best] / expected)
    pause = float(time[at] - time[at - 1])
    if abs(pause - guesses[best]) < _SMALLEST:
        return None
    if moved.min() - costs[best] < unlike:
        return None
    if 0 < pause < _ROOM and cost(pause) - costs[best] < unlike:
        return None
    return float(guesses[best])


def _left(x: Floats, values: Floats, degree: int) -> Floats:
    """Return (N,) the squares that a polynomial leaves of values (W, N)."""
    basis, _ = np.linalg.qr(np.vander(x / np.abs(x).max(), degree + 1))
    return np.asarray(np.sum((values - basis @ (basis.T @ values)) ** 2, axis=0))
