"""Samples that were taken evenly and stamped late: the ticks of the clock that took them.

A driver samples with the robot's own steady clock and stamps later, with a delay that varies, or
stamps all that waited in a queue at once. Such stamps shift a moving joint by velocity × delay, and
two differentiations make large accelerations of it. Which tick a sample belongs to follows from its
stamp and, better, from how far the joints moved since the sample before; whether stamps or ticks
are right follows from which of the two the positions are smooth over.
"""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from lagrangian_ff.arrays import Flags, Floats, Ints
from lagrangian_ff.loops.binding import loop
from lagrangian_ff.recording.splines import LeastSquares

ON_THE_TICK = 1e-3
"""Of a period: stamps this near a uniform clock are on it."""

FEWEST = 100
"""Samples; of fewer nothing is said."""

_PIECE = 0.04  # s, of the splines that follow the motion: up to about 12 Hz
_LEAST_PIECE = 4  # samples in a piece of these
_SURE = 0.2  # of a period: motion that is known better counts the lost samples
_ALIKE = 0.25  # of a step: steps of one clock
_WHILE = 50  # samples
_VAGUE = 0.03  # of the time that motion shows: its error where the velocity is
_LONG = 3.0  # pauses of the stamps in a piece, as long as only these are known
_PLAIN = 0.25  # of a period: if all steps are nearer to whole periods, they count the ticks
_EXTENDED = 5.0  # periods without samples over which motion counts them
_MOSTLY = 0.9  # of the steps: if so many are near to whole periods, they give the period
_NARROW = 0.02  # of a period: least jitter assumed when ticks are counted
_REACH = 120  # ticks
_ALONG = 32  # samples of a block in which delays are alike
_BINS = 4  # to a period, as in the C loop
_OUTLYING = 5.0  # log likelihood of the least likely delay
_PASSES = 6  # most times that ticks are counted again
_WIDER = 1.5  # times the departures of one count are those of the next, if it goes astray
_BLOCK = 1.0  # s, of which the clock is found
_BLOCKS = 10  # at least, of
_IN_BLOCK = 20  # samples at least
_FEWEST_BLOCKS = 5  # of which more than a median is found
_SIMPLER = 10.0  # chi squared that one more coefficient of the clock must explain
_DRIFT = 10.0  # s; slower departures from a line are drift between clocks, not jitter
_JUDGED = 0.5  # s, of stretches that are judged as independent of each other
_CLEAR = 3.0  # standard errors by which the slope must lie below a half
_ROUGHER = 1.1  # times as much jerk is not as smooth
_QUEUE = 3.0  # pauses of the stamps that a sample may be late by


@dataclass(frozen=True)
class Ticks:
    """The ticks of a steady clock at which samples were taken.

    Attributes:
        time: (K,) s, never decreasing.
        follows: slope of the motion on the departures of the stamps: 1 if the stamps are right, 0
            if the ticks are; NaN where the motion does not show it.
        error: its standard error.
        smoother: acceleration changes this many times as much over the stamps as over the ticks.
    """

    time: Floats
    follows: float
    error: float
    smoother: float

    @property
    def right(self) -> bool:
        """Return whether the samples were demonstrably taken at the ticks."""
        return self.follows + _CLEAR * self.error < 0.5 and self.smooth

    @property
    def smooth(self) -> bool:
        """Return whether the motion is as smooth over the ticks at low frequencies, or smoother."""
        return self.smoother * _ROUGHER > 1.0


def ticks_of_motion(
    stamp: Floats, position: Floats, held: Flags, joints: Ints, ask: bool = True
) -> Ticks | None:
    """Return the ticks of samples; None if the stamps are on a uniform clock, or nothing is known.

    Args:
        stamp: (K,) s, in the order in which samples were taken, or nearly sorted.
        position: (K, N) rad.
        held: (K,) samples that repeat the one before.
        joints: the samples before which a step of the clock was undone.
        ask: whether the motion helps to count the ticks; else the stamps alone do.
    """
    step = np.diff(stamp)
    usual = _usual(stamp)
    period = _period(step, np.maximum(np.round(step / usual), 1.0 - held[1:]))
    if not period > 0 or _even(stamp, period):
        return None
    motion = _Moved(stamp, position, held, usual, ask)
    if not motion.counts():
        return None
    ticks = motion.ticks()
    for _ in range(0 if motion.plain and ask else _PASSES):
        time = _clock(stamp, ticks, joints)
        spread = motion.spread
        motion.refine(time)
        if ask and not (motion.counts() and motion.spread < _WIDER * spread):
            # It goes astray: motion with edges counts worse than stamps that count by themselves.
            if not motion.regular:
                return None
            return ticks_of_motion(stamp, position, held, joints, ask=False)
        ticks, before = motion.ticks(), ticks
        if np.array_equal(ticks, before):
            break
    time = _clock(stamp, ticks, joints)
    late = stamp - time
    if np.abs(late).max() <= ON_THE_TICK * motion.period:
        return None
    if np.abs(late).max() > _QUEUE * max(np.abs(step).max(), motion.period):
        return None
    return Ticks(time, *_follows(stamp, time, position))


def _usual(stamp: Floats) -> float:
    """Return the usual distance of samples: of most neighbours, or else on average for a while."""
    step = np.diff(stamp)
    wide = min(_WHILE, len(step))
    average = float(np.median((stamp[wide:] - stamp[:-wide]) / wide))
    middle = float(np.median(step))
    alike = np.mean(np.abs(step - middle) < _ALIKE * abs(middle)) > 0.5
    return middle if alike and middle > average / 2 else average


def _period(step: Floats, count: Floats) -> float:
    """Return the period of a clock that ticked `count` times in each of the steps."""
    return float(step.sum() / count.sum()) if count.sum() > 0 else float("nan")


def _even(stamp: Floats, period: float) -> bool:
    phase = (stamp - stamp[0]) / period
    off = phase - np.round(phase)
    return bool(np.ptp(off) <= 2 * ON_THE_TICK)


class _Moved:
    """How far the motion went between samples, in periods."""

    def __init__(
        self, stamp: Floats, position: Floats, held: Flags, usual: float, ask: bool
    ) -> None:
        self.stamp, self.position, self.period = stamp, position, usual
        self.held = held
        step = np.diff(stamp)
        self._moved, self._noise = step, np.full(len(step), np.inf)
        self._variance = self._noise
        off = np.abs(step / usual - self._count())
        self.plain = not ask or bool(np.quantile(off, 0.999) < _PLAIN)
        near = off < _PLAIN
        self.regular = self.plain or bool(near.mean() > _MOSTLY)
        if self.regular:
            self.period = _period(step[near], self._count()[near])
        if not self.plain:
            piece = max(_PIECE, _LONG * float(np.quantile(step, 0.99)))
            for _ in range(2):
                self._measure(stamp, piece, 3.0)
        count = self._count()
        behind = np.concatenate([[0.0], np.cumsum(np.diff(stamp) / self.period - count)])
        self._judge(behind - np.convolve(behind, np.ones(51) / 51, mode="same"), False)

    def counts(self) -> bool:
        """Return whether ticks can be counted."""
        return bool(np.isfinite(self.period) and self.period > 0 and self.spread < _REACH / 4)

    def refine(self, time: Floats) -> None:
        """Measure again with the velocity over better times."""
        if not self.plain:
            self._measure(time, _PIECE, 1.0)
        self._judge((self.stamp - time) / self.period, True)

    def _judge(self, late: Floats, shape: bool) -> None:
        """Take what delays cost, per sample, from delays (K,) in periods: their size or shape."""
        inside = late[25:-25]
        inside = inside - np.median(inside)
        self.spread = max(_NARROW, float(np.mean(np.abs(inside))))
        # Delays of neighbours are alike, and say the same: twice, as neighbours and blocks show it.
        change = np.mean(np.diff(inside) ** 2) / (2 * np.var(inside) + 1e-24)
        blocks = inside[: len(inside) // _ALONG * _ALONG].reshape(-1, _ALONG).mean(axis=1)
        along = _ALONG * np.var(blocks) / (np.var(inside) + 1e-24)
        self._lasting = max(1.0, 2 / max(float(change), 0.04) - 1, float(along))
        furthest = max(8 * self.spread, float(np.abs(inside - inside.mean()).max()))
        self._reach = int(np.clip(4 + furthest, 4, _REACH))
        bins = np.linspace(-self._reach, self._reach, 2 * _BINS * self._reach + 1)
        self._unlikely = np.minimum(np.abs(bins) / self.spread, _OUTLYING)
        if shape:
            number = np.round(_BINS * (inside - inside.mean() + self._reach)).astype(np.int64)
            count = np.bincount(np.clip(number, 0, len(bins) - 1), minlength=len(bins))
            likely = np.convolve(count, np.array([1, 2, 3, 2, 1]) / 9, mode="same") / len(inside)
            self._unlikely = -np.log(np.maximum(likely / likely.max(), np.exp(-_OUTLYING)))
        self._unlikely = self._unlikely / self._lasting

    def _measure(self, time: Floats, piece: float, doubt: float) -> None:
        """Set the time between samples by their motion, s, its variance, and the period."""
        spline = LeastSquares(time, _pieces(time, piece))
        change = np.diff(self.position, axis=0)
        slope = spline.slopes(spline.fit(self.position))
        velocity = (slope[1:] + slope[:-1]) / 2
        noise = np.ones(change.shape[1])
        for _ in range(2):
            weighted = velocity / noise
            sure = np.einsum("ij,ij->i", weighted, velocity) + 1e-300
            moved = np.einsum("ij,ij->i", weighted, change) / sure
            whole = np.maximum(np.round(moved / self.period), 1.0 - self.held[1:]) * self.period
            left = change - velocity * whole[:, np.newaxis]
            noise = np.mean(left**2, axis=0) + 1e-24
        self._moved = moved
        self._noise, self._variance = 1 / sure, 1 / sure + (doubt * _VAGUE * moved) ** 2
        if self.regular:  # the stamps know more of a pause than the motion on its two sides
            self._variance[np.diff(self.stamp) > _EXTENDED * self.period] = np.inf
        known = self._known() & ~self.held[1:]
        if self.regular or known.sum() < FEWEST:
            return
        middle = float(np.median(moved[known]))
        if middle > 0 and abs(middle / self.period - 1) > _ALIKE:
            self.period = middle
        step = np.diff(self.stamp)
        for _ in range(3):
            count = self._count()
            near = self._known() & (count < (10 if doubt > 1 else 100))
            total = count[near].sum()
            if total > 0 and step[near].sum() > 0:
                self.period = float(step[near].sum() / total)

    def _known(self) -> Flags:
        return np.asarray(self._noise < (_SURE * self.period) ** 2) | self.held[1:]

    def _count(self) -> Floats:
        """Return the periods between samples as far as neighbours show them."""
        span = np.where(self._known(), self._moved, np.diff(self.stamp))
        return np.asarray(np.maximum(np.round(span / self.period), 1.0 - self.held[1:]))

    def ticks(self) -> Ints:
        """Return the number of each sample's tick."""
        count = len(self.stamp)
        out = np.empty(count, dtype=np.int64)
        zero = np.zeros(1)
        loop("clock_ticks")(
            count,
            np.ascontiguousarray((self.stamp - self.stamp[0]) / self.period),
            np.concatenate([zero, self._moved / self.period]),
            np.concatenate([zero, self.period**2 / self._variance]),
            np.ascontiguousarray(self.held, dtype=np.int64),
            self._unlikely,
            self._reach,
            out,
        )
        return out


def _pieces(time: Floats, piece: float = _PIECE) -> int:
    return max(2, int(min(float(np.ptp(time)) / piece, len(time) / _LEAST_PIECE)))


def _clock(stamp: Floats, ticks: Ints, joints: Ints) -> Floats:
    """Return the times of the ticks: those of the simplest clock that the stamps allow.

    In every second, that quantile of the delays is taken which varies least from one second to the
    next: the least delay where delays are bounded below, as a queue's are, the median where they
    are not. Simplest is a clock with a rate of three digits, then any steady one, then one that
    drifts.

    Args:
        joints: the samples before which a step of the clock was undone, by less than exactly.
    """
    tick = ticks - ticks[0]
    period = float(np.polynomial.Polynomial.fit(tick, stamp, 1).convert().coef[1])
    late = stamp - period * tick
    blocks = max(int(tick[-1] * period / _BLOCK), min(_BLOCKS, len(tick) // _IN_BLOCK))
    part = np.minimum(tick * blocks // (tick[-1] + 1), blocks - 1)
    piece = np.searchsorted(joints, np.arange(len(tick)), side="right")
    edges = [0, *(np.flatnonzero(np.diff(part + piece) > 0) + 1), len(tick)]
    parts = [slice(*pair) for pair in pairwise(edges)]
    if len(parts) < _FEWEST_BLOCKS + len(joints):
        return np.asarray(period * tick + np.median(late))
    middle = np.array([tick[rows].mean() for rows in parts])
    level, scatter, bounded = np.empty(0), np.inf, False
    for share in (0.0, 0.02, 0.5):
        found = np.array([np.quantile(late[rows], share) for rows in parts])
        found -= _offsets(middle, found, piece[edges[:-1]])
        noise = float(np.var(np.diff(found, 2))) / 6
        if noise < scatter:
            level, scatter, bounded = found, noise, share == 0.0
    more = _round_period(period) - period
    line = np.polynomial.Polynomial.fit(middle, level, 1)
    rest = np.mean(level - more * middle)
    models = [(1, more * middle + rest, more * tick + rest), (2, line(middle), line(tick))]
    pieces = int(tick[-1] * period / _DRIFT)
    if pieces >= 2 and len(parts) > 2 * (pieces + 3):
        span = np.array([0.0, tick[-1]])
        near = LeastSquares(middle, pieces, span)
        weights = near.fit(level)
        along = near.values(weights, tick.astype(np.float64))
        models.append((pieces + 3, near.values(weights), along))
    # Delays that wander look like another rate: what they leave of a line is noise as well.
    noise = max(scatter, float(np.var(level - models[1][1]))) + 1e-18
    costs = [
        np.sum((level - near) ** 2) / noise + _SIMPLER * count for count, near, _ in models[:2]
    ]
    best = models[int(np.argmin(costs))]
    for other in models[2:]:
        gain = np.sum((level - best[1]) ** 2 - (level - other[1]) ** 2) / (scatter + 1e-18)
        if gain > _SIMPLER * (other[0] - best[0]):
            best = other
    time = period * tick + best[2]
    # Nothing is stamped before it is measured.
    return np.asarray(time + np.min(stamp - time) if bounded else time)


def _offsets(middle: Floats, level: Floats, piece: Ints) -> Floats:
    """Return by how much each level lies above the line of the first piece."""
    pieces = piece[:, np.newaxis] == np.unique(piece)
    basis = np.column_stack([pieces, middle / max(middle[-1], 1.0)])
    weights = np.linalg.lstsq(basis, level, rcond=None)[0]
    return np.asarray(pieces @ (weights[:-1] - weights[0]))


def _round_period(period: float) -> float:
    """Return the period of the nearest rate, or the nearest period, of three digits."""
    rate = float(f"{1 / period:.3g}")
    whole = float(f"{period:.3g}")
    return 1 / rate if abs(1 / rate - period) <= abs(whole - period) else whole


def _follows(stamp: Floats, time: Floats, position: Floats) -> tuple[float, float, float]:
    """Return the slope of the motion on the stamps' departures, its error, and `smoother`."""
    pieces = _pieces(time)
    over_ticks, over_stamps = LeastSquares(time, pieces), LeastSquares(stamp, pieces)
    late = stamp - time
    block = ((time - time.min()) / _JUDGED).astype(np.int64)
    blocks = int(block.max()) + 1
    position = position[:, np.ptp(position, axis=0) > 0]
    weights = over_ticks.fit(position)
    found = position - over_ticks.values(weights)
    expected = over_ticks.slopes(weights) * late[:, np.newaxis]
    expected -= over_ticks.values(over_ticks.fit(expected))
    spread = np.var(found, axis=0) + 1e-24
    numerator = np.bincount(block, expected * found @ (1 / spread), blocks)
    denominator = np.bincount(block, expected**2 @ (1 / spread), blocks)
    jerks = [
        np.sum(np.diff(fit, 3, axis=0) ** 2, axis=0) + 1e-300
        for fit in (over_stamps.fit(position), weights)
    ]
    smoother = float(np.mean(jerks[0] / jerks[1])) if position.shape[1] else 1.0
    if denominator.sum() == 0:
        return float("nan"), float("nan"), 1.0
    slope = float(numerator.sum() / denominator.sum())
    left = numerator - slope * denominator
    scatter = np.sqrt(np.sum(left**2)) / denominator.sum()
    error = max(float(scatter), 1 / np.sqrt(denominator.sum()))
    return slope, error, smoother
