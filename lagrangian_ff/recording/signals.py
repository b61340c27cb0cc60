"""The signals of a recording, each with its own sampling.

Position and effort of a joint need not share their samples: several publishers may send different
joints, single values may be NaN. Columns that share them are handled together.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lagrangian_ff.arrays import Floats, Ints
from lagrangian_ff.recording.clock import retime
from lagrangian_ff.recording.late import ON_THE_TICK
from lagrangian_ff.recording.recording import Recording
from lagrangian_ff.recording.splines import LeastSquares, interpolate
from lagrangian_ff.recording.stamps import order, usual_period
from lagrangian_ff.words import counted

Spans = NDArray[np.float64]
"""(S, 2) s, begin and end of intervals of time, in order."""
_PAUSE = 2.5
"""Periods, from which on a step from sample to sample is a pause."""
_PIECE = 0.7
"""Length of a spline's pieces over that of a pause: longer ones follow the motion less well than a
spline through the samples, shorter ones follow the noise."""
_BESIDE = 8.0
"""A pause is filled from the samples up to this many pieces before and after it."""


@dataclass(frozen=True)
class Sampling:
    """The sampling of some columns.

    Attributes:
        time: (K,) s, increasing strictly.
        index: (K,) their rows in the recording.
        period: s, the usual distance of two samples.
    """

    time: Floats
    index: Ints
    period: float

    def gaps(self, longest: float) -> Spans:
        """Return the pauses longer than `longest` seconds."""
        at = np.flatnonzero(np.diff(self.time) > longest * (1 + 1e-9))
        return np.column_stack([self.time[at], self.time[at + 1]])

    def on_clock(self, columns: Floats, ticks: Floats) -> Floats:
        """Return columns of the recording at these times, (M, C).

        Samples that lie on the ticks are kept as they are; between samples a cubic spline
        interpolates, and across pauses one that goes near the samples beside them.
        """
        first = max(0, int(np.searchsorted(self.time, ticks[0], side="right")) - 1)
        last = int(np.searchsorted(self.time, ticks[-1], side="left")) + 1
        time, values = self.time[first:last], columns[self.index[first:last]]
        near = self.near(time, ticks)
        on_ticks = len(time[near]) == len(ticks)
        if on_ticks and np.abs(time[near] - ticks).max() <= ON_THE_TICK * self.period:
            return values[near]
        time, values = bridged(time, values, ticks, self.period)
        return np.stack([interpolate(time, column, ticks) for column in values.T], axis=1)

    def near(self, time: Floats, ticks: Floats) -> slice:
        """Return the times within half a period of the first to the last tick."""
        half = self.period / 2
        first, last = np.searchsorted(time, [ticks[0] - half, ticks[-1] + half])
        return slice(int(first), int(last))


def bridged(time: Floats, values: Floats, ticks: Floats, period: float) -> tuple[Floats, Floats]:
    """Return times and samples (K, C), with more of both at the ticks within pauses.

    A spline through the samples takes its slope at the edge of a pause from their noise, and the
    longer the pause, the further it swings out. One of long pieces, nearest to the samples on both
    sides, follows the motion as well and has no more noise than they.
    """
    longest = np.diff(time).max() / (_PAUSE * period)
    # The longest first: a sample alone between two pauses says little about the shorter one.
    for octave in range(int(np.floor(np.log2(longest))), -1, -1):
        step, least = np.diff(time), 2.0**octave * _PAUSE * period
        pauses = np.flatnonzero((step >= least) & (step < 2.0 * least))
        if not len(pauses):
            continue
        piece = _PIECE * step[pauses].max()
        near = np.zeros(len(time) + 1, dtype=np.int64)
        np.add.at(near, np.searchsorted(time, time[pauses] - _BESIDE * piece), 1)
        np.add.at(near, np.searchsorted(time, time[pauses + 1] + _BESIDE * piece), -1)
        beside = np.cumsum(near[:-1]) > 0
        at = np.clip(np.searchsorted(time, ticks) - 1, 0, len(step) - 1)
        away = np.minimum(ticks - time[at], time[at + 1] - ticks) > 0.5 * period
        lost = ticks[away & np.isin(at, pauses)]
        pieces = int(np.ceil((time[-1] - time[0]) / piece))
        spline = LeastSquares(time[beside], pieces, time[[0, -1]])
        values = np.concatenate([values, spline.values(spline.fit(values[beside]), lost)])
        time = np.concatenate([time, lost])
        index = np.argsort(time, kind="stable")
        time, values = time[index], values[index]
    return time, values


@dataclass(frozen=True)
class Signals:
    """The samplings of a recording.

    Attributes:
        samplings: all that differ.
        position, effort: (N,) index of the sampling of each joint's position and effort.
    """

    samplings: tuple[Sampling, ...]
    position: tuple[int, ...]
    effort: tuple[int, ...]

    @property
    def fastest(self) -> Sampling:
        """Return the sampling with the shortest period; the common clock follows it."""
        return min(self.samplings, key=lambda sampling: sampling.period)

    @property
    def slowest(self) -> Sampling:
        """Return the sampling with the longest period; it limits the bandwidth."""
        return max(self.samplings, key=lambda sampling: sampling.period)

    def on_clock(self, table: Floats, numbers: Sequence[int], ticks: Floats) -> Floats:
        """Return a table (M, N) of the recording at these times.

        Args:
            numbers: (N,) the sampling of each column, as in `position`.
        """
        out = np.empty((len(ticks), len(numbers)))
        for number in set(numbers):
            here = [column for column, of in enumerate(numbers) if of == number]
            out[:, here] = self.samplings[number].on_clock(table[:, here], ticks)
        return out

    def mended(self, clocks: list[Floats]) -> "Mended":
        """Return how far these clocks depart from the samples of the fastest signal."""
        fastest = self.fastest
        period = fastest.period
        bridged, longest, off_clock = 0, 0.0, 0.0
        for ticks in clocks:
            time = fastest.time[fastest.near(fastest.time, ticks)]
            step = np.diff(time)
            lost = step[step > 1.75 * period]
            bridged += int((np.round(lost / period) - 1).sum())
            longest = max(longest, lost.max(initial=0.0))
            behind = (time - ticks[0]) / period
            off_clock = max(off_clock, period * np.abs(behind - np.round(behind)).max(initial=0.0))
        if off_clock <= ON_THE_TICK * period:
            off_clock = 0.0
        return Mended(bridged, float(longest), float(off_clock))


@dataclass(frozen=True)
class Mended:
    """The departure of a uniform clock from the samples.

    Attributes:
        bridged: ticks for which no sample was recorded.
        longest: s, the longest pause among these.
        off_clock: s, the largest distance of a sample from its tick; 0 where negligible.
    """

    bridged: int
    longest: float
    off_clock: float


def read_signals(recording: Recording, clock: str, notes: list[str]) -> Signals:
    """Return the signals, with stamps in order column by column; notes say what was changed.

    Args:
        clock: "auto", "stamps" or "steady", as in `Conditioning`.
    """
    time = retime(recording, clock, notes)
    samplings: dict[bytes, int] = {}
    found: list[Sampling] = []
    moved = repeated = 0
    groups: dict[str, list[int]] = {"position": [], "effort": []}
    for quantity, numbers in groups.items():
        table = getattr(recording, quantity)
        for joint in range(len(recording.joints)):
            known = np.isfinite(table[:, joint])
            key = np.packbits(known).tobytes()
            if key not in samplings:
                rows = np.flatnonzero(known)
                ordered = order(time[rows])
                moved, repeated = max(moved, ordered.moved), max(repeated, ordered.repeated)
                index = rows[ordered.index]
                samplings[key] = len(found)
                found.append(Sampling(time[index], index, usual_period(np.diff(time[index]))))
            numbers.append(samplings[key])
    if moved:
        notes.append(f"{counted(moved, 'sample')} arrived out of order; sorted by their stamps")
    if repeated:
        notes.append(f"stamps repeated by {counted(repeated, 'sample')}; the first of each is used")
    return Signals(tuple(found), tuple(groups["position"]), tuple(groups["effort"]))


def uninterrupted(signals: Signals, longest: float) -> Spans:
    """Return the spans in which no signal pauses longer than `longest` seconds.

    Signals slower than the fastest may pause for 2.5 of their periods.
    """
    begin = max(sampling.time[0] for sampling in signals.samplings)
    end = min(sampling.time[-1] for sampling in signals.samplings)
    slow = 1.5 * signals.fastest.period
    gaps = np.concatenate(
        [
            each.gaps(max(longest, 2.5 * each.period) if each.period > slow else longest)
            for each in signals.samplings
        ]
    )
    spans = []
    for gap_begin, gap_end in gaps[np.argsort(gaps[:, 0])]:
        if gap_begin > begin:
            spans.append((begin, min(gap_begin, end)))
        begin = max(begin, gap_end)
    if begin < end:
        spans.append((begin, end))
    return np.array([span for span in spans if span[0] < span[1]]).reshape(-1, 2)


def ticks_of(sampling: Sampling, span: Floats) -> Floats:
    """Return the uniform clock of a span, of the sampling's period and in phase with it."""
    time = sampling.time
    begin, end = np.searchsorted(time, span[0]), np.searchsorted(time, span[1], side="right")
    inside = time[begin:end]
    period = sampling.period
    origin = inside[0] if inside.size else span[0]
    behind = (inside - origin) / period
    phase = float(np.mean(behind - np.round(behind))) if inside.size else 0.0
    first = np.ceil((span[0] - origin) / period - phase - ON_THE_TICK)
    last = np.floor((span[1] - origin) / period - phase + ON_THE_TICK)
    return np.asarray(origin + period * (phase + np.arange(first, last + 1)))
