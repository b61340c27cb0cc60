"""A limit that cuts the torque, seen where the motion demands more.

A torque that is cut follows the model up to a level and no further, whatever more the model
expects. A round peak follows it to the end; a model that expects too much is followed by a smaller
torque, but not by a constant one. (That the effort rests on one value exactly is seen in the
recording itself, by `recording.inspection.clipped`: the low-pass blurs it.)
"""

from dataclasses import dataclass

import numpy as np

from lagrangian_ff.arrays import Flags, Floats, Ints
from lagrangian_ff.diagnosis.preflight.base import MARGIN, Case, Check, rate_of
from lagrangian_ff.kernels import States

SHARE = 0.002
"""Least share of the time in which the model expects more than the limit."""
BEYOND = 5.0
"""Times the model's error by which it must expect more, at the highest (95 %) of these times."""
FOLLOWS = 0.3
"""Most that the torque beyond a limit may follow the model; a round peak follows it by 1."""
STRETCHES = 3
"""Least number of times that the limit was reached."""
LONG = 0.04
"""Least s of each: the filter's own time."""
_DEVIATIONS = 3.0  # of how far it follows, by stretches left out
_LEVELS = 80  # that are tried
_BELOW = 0.3  # of the range above the median: where the model's error is taken, below the level


@dataclass(frozen=True)
class _Limit:
    """A level in N·m, the share of the time beyond it, and when it was reached first, in s."""

    level: float
    share: float
    first: float


def check_saturation(case: Case) -> list[Check]:
    """Report a measured torque that stays at a level while the model expects more."""
    advice = (
        "Repeat the motion slower or without payload, so that no torque reaches the limit; or add "
        "the effect saturation"
    )
    thin = case.thin
    excess = case.model.range.excess(States.of(thin.q, thin.qd, thin.qdd))
    inside = np.asarray(np.all(excess <= MARGIN, axis=1))
    found = []
    for n in np.flatnonzero(case.clear).tolist():
        name = case.joints[n]
        for sign in (1.0, -1.0):
            expected = sign * np.sign(case.slope[n]) * case.predicted[:, n]
            limit = _limit(case, sign * thin.tau[:, n], expected, inside)
            if limit is None:
                continue
            level = sign * limit.level
            finding = (
                f"the effort of {name} stays at {level:.4g} N·m where the model expects more, "
                f"{limit.share:.1%} of the time, first at {limit.first:.2f} s: a limit cuts it"
            )
            values = {"level": level, "share": limit.share, "first": limit.first}
            found.append(Check("saturation", name, finding, True, advice, values))
    return found


def _limit(case: Case, tau: Floats, expected: Floats, inside: Flags) -> _Limit | None:
    """Return the limit that cuts a torque from above, if there is one."""
    middle = float(np.median(tau[inside]))
    room = float(tau[inside].max()) - middle
    if room <= 0.0:
        return None
    # Its unit and offset where no limit cuts.
    low = inside & (expected < np.median(expected[inside]))
    less = expected[low] - expected[low].mean()
    factor = float(less @ tau[low]) / max(float(less @ less), 1e-300)
    expected = tau[low].mean() + factor * (expected - expected[low].mean())
    level = _level(tau[inside], expected[inside], middle)
    if level is None:
        return None
    below = inside & (expected < level) & (expected > level - _BELOW * room)
    beyond = inside & (expected > level)
    error = float(np.sqrt(np.mean((tau - expected)[below] ** 2))) if below.any() else np.inf
    if np.quantile(expected[beyond] - level, 0.95) < BEYOND * error:
        return None
    numbers = _stretches(case, beyond)
    reached = np.unique(numbers[numbers >= 0])
    if reached.size < STRETCHES or np.mean(numbers >= 0) < SHARE:
        return None
    at = numbers >= 0
    if _follows(tau[at] - level, expected[at] - level, numbers[at]) > FOLLOWS:
        return None
    first = float(case.thin.time[int(np.argmax(at))])
    return _Limit(float(np.median(tau[at])), float(beyond.mean()), first)


def _level(tau: Floats, expected: Floats, middle: float) -> float | None:
    """Return the level at which cutting the expected torque leaves the least squared error."""
    top = float(expected.max())
    if top <= middle:
        return None
    order = np.argsort(expected)
    tau, expected = tau[order], expected[order]
    free = np.concatenate([[0.0], np.cumsum((tau - expected) ** 2)])
    first, second = (np.concatenate([[0.0], np.cumsum(one)]) for one in (tau, tau**2))
    levels = np.linspace(middle, top, _LEVELS, endpoint=False)
    k = np.searchsorted(expected, levels, "right")
    above = len(tau) - k
    cut = (second[-1] - second[k]) - 2 * levels * (first[-1] - first[k]) + above * levels**2
    best = int(np.argmin(free[k] + cut))
    return float(levels[best]) if best else None


def _stretches(case: Case, beyond: Flags) -> Ints:
    """Return (M,) the number of the stretch beyond the level, -1 outside and in short ones."""
    motion = case.thin
    begins = beyond & ~np.concatenate([[False], beyond[:-1] & (np.diff(motion.segment) == 0)])
    numbers = np.where(beyond, np.cumsum(begins) - 1, -1)
    long = np.bincount(numbers[beyond]) >= max(2.0, LONG * rate_of(motion))
    return np.where(beyond & long[numbers], numbers, -1)


def _follows(tau: Floats, expected: Floats, stretch: Ints) -> float:
    """Return the slope of the torque over the expected one, at most, by stretches left out.

    Both are relative to the level, and the line passes through it: torque that rests on the level
    has a slope of 0, torque that goes on with the model one of 1.
    """
    _, number = np.unique(stretch, return_inverse=True)
    products = np.bincount(number, tau * expected), np.bincount(number, expected**2)
    left = [one.sum() - one for one in products]
    slopes = left[0] / np.maximum(left[1], 1e-300)
    slope = products[0].sum() / products[1].sum()
    count = len(slopes)
    spread = np.sqrt((count - 1) / count * np.sum((slopes - slopes.mean()) ** 2))
    return float(slope + _DEVIATIONS * spread)
