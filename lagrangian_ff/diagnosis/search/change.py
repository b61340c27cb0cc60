"""Did something take hold of the arm? A second Lagrangian within an interval of time.

A load at the hand changes masses, and with them the torque of every joint before it, in a pattern
that no curve over one joint's coordinate follows. What it adds is again a Lagrangian's torque, and
so is what a force on the hand adds, the transpose of the Jacobian times the force: the evidence is
asked whether the rigid-body part has a second part, from some moment on or for a while.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from lagrangian_ff.diagnosis.ground import Changing, Ground
from lagrangian_ff.progress import Progress, silent

Floats = NDArray[np.float64]

SAMPLES = 200
STEP, MARGIN = 5.0, 6.0
"""s between the moments tried, and from the ends of a motion."""
LEAST = 3.0
"""s of motion before and after a moment, without which nothing has changed on the way."""
COARSE, EXACT = (2.5, 1.25, 0.625), (0.3, 0.15, 0.075, 0.04)
"""s that the moments are moved by: of few samples, and of all. What is between the true moment and
the one found is a torque that another effect would be named for."""
LENGTHS = (np.inf, 5.0, 10.0)
SHARE = 0.05
FINE = (0.005, 0.02, 0.08, 0.3, 1.0)
WORTH = 100.0
"""Nats that a change of the arm must be worth: a second Lagrangian is a large freedom."""
PROMISING = 3.0
SHUFFLES = 5
BEYOND_CHANCE, AGAIN = 4.0, 2.0
"""How many times what shuffled blocks gain a change must gain, and one that was found before."""
OFFSETS = 0.15 * 1.5 ** np.arange(11)
"""s that a moment is moved by, either way, to see how well it is known."""
HALF_CHI_SQUARE = 1.353
"""Nats that the evidence falls by at the ends of a 90 % interval: half the quantile of χ² (1)."""
FELT = 0.02
"""Share of a joint's torque from which on the joint is said to feel a load."""


@dataclass(frozen=True)
class Change:
    """A load taken up, or a contact.

    Attributes:
        since, until: s; it lasts to the end where `until` is infinite.
        share: variance of what is added, in parts of that of the rigid-body torque.
        gain: nats of log evidence.
        since_range, until_range: s, the 90 % intervals of both moments.
    """

    since: float
    until: float
    share: float
    gain: float
    since_range: tuple[float, float] = (-np.inf, np.inf)
    until_range: tuple[float, float] = (-np.inf, np.inf)

    @property
    def name(self) -> str:
        """What it is called in the catalogue."""
        return "contact" if np.isfinite(self.until) else "payload"

    @property
    def prior(self) -> tuple[float, float, float]:
        """As a prior takes it."""
        return self.since, self.until, self.share


def change_of(
    ground: Ground, progress: Progress = silent, beyond: float = BEYOND_CHANCE
) -> Change | None:
    """The interval in which the evidence gains most from a second Lagrangian.

    Few samples tell whether and roughly when, all of them how much and when. None where even the
    best interval is not worth it, or where the motion is of several recordings, each with a time of
    its own: a moment of one is none of the others.

    Args:
        ground: of the motion.
        progress: told the share done.
        beyond: how many times what shuffled blocks gain it must gain.
    """
    time = ground.seen.time
    if not np.isfinite(time).all() or float(np.ptp(time)) < 2.5 * MARGIN:
        return None
    if (np.diff(time) < 0.0).any():
        return None
    start, end = float(time.min()), float(time.max())
    coarse = _gains(ground, SAMPLES)
    tried = _Better(coarse, start, end)
    best = Change(start, np.inf, SHARE, -np.inf)
    moments = np.arange(start + MARGIN, end - MARGIN, STEP).tolist()
    for number, since in enumerate(moments):
        progress(number / len(moments), "asking whether a load was taken up")
        for length in LENGTHS:
            best = tried(best, since, since + length, SHARE)
    if best.gain < PROMISING:
        return None
    best = tried.moved(best, COARSE)
    for share in FINE:
        best = tried(best, best.since, best.until, share)
    best = tried(best, best.since, np.inf, best.share)
    if best.gain < beyond * max(_shuffled_gains(ground, best)):
        return None
    every = _gains(ground, len(ground.index))
    best = replace(best, gain=every(best))
    if best.gain <= WORTH:
        return None
    best = _Better(every, start, end).moved(best, EXACT)
    return _with_ranges(best, coarse, (start, end))


@dataclass(frozen=True)
class _Better:
    """The better of two changes, within a motion from `start` to `end`."""

    gain: Callable[[Change], float]
    start: float
    end: float

    def __call__(self, best: Change, since: float, until: float, share: float) -> Change:
        """The best, or the change that these make if that gains more."""
        if until > self.end - 1.0:
            until = np.inf
        if until - since < 1.0 or not self.start + LEAST < since < self.end - LEAST:
            return best
        change = Change(since, until, share, 0.0)
        gain = self.gain(change)
        return replace(change, gain=gain) if gain > best.gain else best

    def moved(self, best: Change, steps: Sequence[float]) -> Change:
        """The best with its moments moved by steps of s, either way."""
        for step in steps:
            best = self._either_way(best, step, 0.0)
            if np.isfinite(best.until):
                best = self._either_way(best, 0.0, step)
        return best

    def _either_way(self, best: Change, since: float, until: float) -> Change:
        for way in (-1.0, 1.0):
            moved = self(best, best.since + way * since, best.until + way * until, best.share)
            if moved is not best:
                return moved
        return best


def _with_ranges(
    best: Change, gain: Callable[[Change], float], motion: tuple[float, float]
) -> Change:
    """The change with how well its moments are known: where the evidence has fallen enough.

    Asked of few samples, as the search was: the intervals are rather too wide than too narrow.
    """
    least = gain(best) - HALF_CHI_SQUARE

    def end(moment: float, moved: Callable[[float], Change], way: float) -> float:
        shifts = (way * float(offset) for offset in OFFSETS)
        found = (moment + shift for shift in shifts if gain(moved(moment + shift)) < least)
        return float(np.clip(next(found, way * np.inf), *motion))

    def since(moment: float) -> Change:
        return replace(best, since=moment)

    def until(moment: float) -> Change:
        return replace(best, until=moment)

    best = replace(best, since_range=(end(best.since, since, -1.0), end(best.since, since, 1.0)))
    if np.isinf(best.until):
        return replace(best, until_range=(np.inf, np.inf))
    return replace(best, until_range=(end(best.until, until, -1.0), end(best.until, until, 1.0)))


def _shuffled_gains(ground: Ground, change: Change) -> list[float]:
    """What the same change gains where blocks of time are put in another order.

    A rigid-body part that fits badly gains from any freedom. Only what belongs to this interval,
    and not to as many blocks from anywhere, tells of something that happened.
    """
    numbers = np.unique(ground.block)
    starts = np.array([ground.seen.time[ground.block == number][0] for number in numbers])
    place = np.searchsorted(numbers, ground.block)
    gains = []
    for seed in range(SHUFFLES):
        order = np.random.default_rng(seed).permutation(len(numbers))
        time = ground.seen.time - starts[place] + starts[order][place]
        shuffled = replace(ground, seen=replace(ground.seen, time=time))
        gains.append(_gains(shuffled, SAMPLES)(change))
    return gains


def joints_of(ground: Ground) -> tuple[tuple[int, ...], Floats]:
    """Which joints feel the change that is in a ground's prior.

    Returns:
        Their indices, the most affected first, and (N,) the root mean square of the added torque
        over that of each joint's torque.
    """
    weights = ground.system.weights.reshape(len(ground.index), ground.joints)
    x = ground.seen
    added = ground.prior.torque(x, x, weights)
    added -= replace(ground.prior, change=None).torque(x, x, weights)
    share = np.sqrt(np.mean(added**2, axis=0)) / np.maximum(ground.spread, 1e-12)
    order = [int(n) for n in np.argsort(-share) if share[n] > FELT]
    return tuple(order or [int(np.argmax(share))]), share


def _gains(ground: Ground, samples: int) -> Callable[[Change], float]:
    changing = Changing.of(ground, samples, ground.extra)
    return lambda change: changing.gain(change.prior)
