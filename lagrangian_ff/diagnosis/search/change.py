"""The interval in which the arm carries a load: a second Lagrangian within it.

A load at the hand changes the torque of every joint before it, in a pattern that no curve over one
joint's coordinate follows. The torque it adds comes from a Lagrangian, and so does that of a force
on the hand (the transposed Jacobian times the force). The log Bayes factor compares the rigid-body
prior with one that has a second part from some moment on, or for a while.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from lagrangian_ff.arrays import Flags, Floats, Ints
from lagrangian_ff.diagnosis import thresholds
from lagrangian_ff.diagnosis.results import Change
from lagrangian_ff.diagnosis.search.bayes_factor import expected, tempered_log_bf
from lagrangian_ff.diagnosis.whitening import Changing, Whitened
from lagrangian_ff.diagnosis.whitening.whitened import rigid_torque
from lagrangian_ff.identification.problem import within

SAMPLES = 200
STEP, MARGIN = 5.0, 6.0
"""Time in s between the moments tried, and from them to the ends of a motion."""
COARSE, EXACT = (2.5, 1.25, 0.625), (0.3, 0.15, 0.075, 0.04)
"""Shifts of the moments in s, on few samples and on all. Between the true moment and the one
found lies a torque that would be taken for another effect."""
EDGE = 0.3
"""s from the ends of the search within which a moment is none."""
LENGTHS = (np.inf, 5.0, 10.0)
SHARE = 0.05
FINE = (0.005, 0.02, 0.08, 0.3, 1.0)
SHUFFLES = 15
OFFSETS = 0.15 * 1.5 ** np.arange(11)
"""Shifts of a moment in s, either way, for its interval."""
HALF_CHI_SQUARE = 1.353
"""Nats by which the log evidence falls at the ends of a 90 % interval."""


def change_of(whitened: Whitened, beyond: float | None = None) -> Change | None:
    """Return the interval in which a second Lagrangian has the largest log Bayes factor.

    Few samples find the interval roughly, all samples exactly. The result is None if the evidence
    is too weak, or if the motion consists of several recordings: their times are unrelated.

    Args:
        whitened: the motion.
        beyond: the least of `beyond_chance`; None takes that of the thresholds.
    """
    limits = thresholds.USED
    beyond = limits.change_beyond_chance if beyond is None else beyond
    time = whitened.x.time
    if not np.isfinite(time).all() or float(np.ptp(time)) < limits.change_motion:
        return None
    if (np.diff(time) < 0.0).any():
        return None
    start, end = float(time.min()), float(time.max())
    coarse = _log_bayes_factors(whitened, SAMPLES)
    tried = _Better(coarse, start, end)
    best = Change(start, np.inf, SHARE, -np.inf)
    for since in np.arange(start + MARGIN, end - MARGIN, STEP).tolist():
        for length in LENGTHS:
            best = tried(best, since, since + length, SHARE)
    if best.log_bayes_factor < limits.change_promising:
        return None
    best = tried.moved(best, COARSE)
    for share in FINE:
        best = tried(best, best.since, best.until, share)
    best = tried(best, best.since, np.inf, best.share)
    if beyond_chance(whitened, best) < beyond or _of_one_block(whitened, best):
        return None
    every = _log_bayes_factors(whitened, len(whitened.index))
    best = replace(best, log_bayes_factor=every(best))
    if best.log_bayes_factor <= limits.change_floor:
        return None
    best = _Better(every, start, end).moved(best, EXACT)
    # A moment at the end of the search would be earlier or later still: the motion has no moment.
    if not start + limits.change_margin + EDGE < best.since < end - limits.change_margin - EDGE:
        return None
    if best.log_bayes_factor - _of_friction(whitened, best) <= limits.change_floor:
        return None
    return _with_ranges(best, coarse, (start, end))


@dataclass(frozen=True)
class _Better:
    """The choice of the better of two changes, within a motion from `start` to `end`."""

    log_bayes_factor: Callable[[Change], float]
    start: float
    end: float

    def __call__(self, best: Change, since: float, until: float, share: float) -> Change:
        """Return the best, or the change with these moments if its log Bayes factor is larger."""
        shortest, margin = thresholds.USED.change_shortest, thresholds.USED.change_margin
        if until > self.end - shortest:
            until = np.inf
        if until - since < shortest or not self.start + margin < since < self.end - margin:
            return best
        change = Change(since, until, share, 0.0)
        change = replace(change, log_bayes_factor=self.log_bayes_factor(change))
        return change if change.log_bayes_factor > best.log_bayes_factor else best

    def moved(self, best: Change, steps: Sequence[float]) -> Change:
        """Return the best with its moments moved by steps of s, either way."""
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


def _of_friction(whitened: Whitened, change: Change) -> float:
    """Return the log Bayes factor of other friction and offsets of all joints in an interval.

    An arm that creeps for a while, or that something holds, meets these; that is no load. Of a load
    they explain a part only, since its torque changes with the pose.
    """
    x = whitened.x
    inside = within(change.prior, x).astype(np.float64)
    columns = []
    for n in range(whitened.joints):
        raw = np.stack([inside, inside * x.sign(n), inside * x.qd[:, n]], axis=1)
        scaled = raw * expected(raw, float(whitened.spread[n]))
        columns.append(whitened.project(whitened.whitened(scaled, n)))
    z = np.hstack(columns)
    return float(tempered_log_bf((z.T @ whitened.residual)[None], z.T @ z, 1.0)[0])


def _of_one_block(whitened: Whitened, change: Change) -> bool:
    """Return whether most of the gain of a change comes from a single block.

    A load is felt in every block. What shows in one only, a touch or gears that begin to slide,
    gains as well with a moment beside it.
    """
    gains = [_log_bayes_factors(whitened, SAMPLES)(change)]
    for number in np.unique(whitened.block):
        kept = np.flatnonzero(whitened.block != number)
        problem, index = whitened.problem.take(kept), whitened.index[kept]
        shorter = replace(whitened, problem=problem, index=index)
        gains.append(_log_bayes_factors(shorter, SAMPLES)(change))
    return bool(min(gains) < thresholds.USED.change_elsewhere * gains[0])


def _with_ranges(
    best: Change, log_bf: Callable[[Change], float], motion: tuple[float, float]
) -> Change:
    """Return the change with 90 % intervals of its moments, from the fall of the log evidence.

    `log_bf` sees few samples, as the search did: the intervals are rather too wide than too narrow.
    """
    least = log_bf(best) - HALF_CHI_SQUARE

    def end(moment: float, moved: Callable[[float], Change], way: float) -> float:
        tried = (moment + way * float(offset) for offset in OFFSETS)
        found = (shifted for shifted in tried if log_bf(moved(shifted)) < least)
        return float(np.clip(next(found, way * np.inf), *motion))

    def ends(moment: float, moved: Callable[[float], Change]) -> tuple[float, float]:
        return end(moment, moved, -1.0), end(moment, moved, 1.0)

    since, until = ends(best.since, lambda at: replace(best, since=at)), (np.inf, np.inf)
    if np.isfinite(best.until):
        until = ends(best.until, lambda at: replace(best, until=at))
    return replace(best, since_range=since, until_range=until)


def beyond_chance(whitened: Whitened, change: Change) -> float:
    """Return by how many standard deviations a change gains more than as many blocks from anywhere.

    A rigid-body part that fits badly gains from any freedom; a real change gains more in its own
    interval. Few samples decide.
    """
    numbers = np.unique(whitened.block)
    starts = np.array([whitened.x.time[whitened.block == number][0] for number in numbers])
    place = np.searchsorted(numbers, whitened.block)
    inside = (starts >= change.since) & (starts < change.until)
    found = []
    for seed in range(SHUFFLES):
        order = _mixed(inside, np.random.default_rng(seed))
        time = whitened.x.time - starts[place] + starts[order][place]
        x = replace(whitened.x, time=time)
        samples = replace(whitened.problem.samples, x=x)
        shuffled = replace(whitened, problem=whitened.problem.of(samples))
        found.append(_log_bayes_factors(shuffled, SAMPLES)(change))
    gain = _log_bayes_factors(whitened, SAMPLES)(change)
    return (gain - float(np.mean(found))) / max(float(np.std(found, ddof=1)), 1.0)


def _mixed(inside: Flags, random: np.random.Generator) -> Ints:
    """Return an order of blocks in which as large a share inside comes from inside as of all.

    Of few blocks a free order leaves many where they were, and gains by the change itself.
    """
    within, beyond = (random.permutation(np.flatnonzero(one)) for one in (inside, ~inside))
    stay = round(len(within) ** 2 / len(inside))
    move = len(within) - stay
    order = np.empty(len(inside), dtype=np.int64)
    order[inside] = random.permutation(np.concatenate([within[:stay], beyond[:move]]))
    order[~inside] = random.permutation(np.concatenate([within[stay:], beyond[move:]]))
    return order


def joints_of(whitened: Whitened) -> tuple[tuple[int, ...], Floats]:
    """Return the joints that feel the change in the prior of a whitened motion.

    Returns:
        Their indices, the most affected first, and (N,) the root mean square of the added torque
        over that of each joint's torque.
    """
    weights = whitened.system.weights.reshape(len(whitened.index), whitened.joints)
    x = whitened.x
    problem = whitened.problem
    added = rigid_torque(problem, x, weights)
    added -= rigid_torque(replace(problem, change=None), x, weights)
    share = np.sqrt(np.mean(added**2, axis=0)) / np.maximum(whitened.spread, 1e-12)
    order = [int(n) for n in np.argsort(-share) if share[n] > thresholds.USED.felt]
    return tuple(order or [int(np.argmax(share))]), share


def _log_bayes_factors(whitened: Whitened, samples: int) -> Callable[[Change], float]:
    """Return the log Bayes factor on some of the samples, as a function of the change."""
    changing = Changing.of(whitened, samples)
    return lambda change: changing.log_bayes_factor(change.prior)
