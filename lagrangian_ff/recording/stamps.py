"""Time stamps as they come: unordered, repeated, with gaps, set back, or late.

A driver samples with the robot's own steady clock and often stamps later, with a delay that
varies. Such stamps shift a moving joint by velocity × delay, and two differentiations make large
accelerations of it. The motion shows it: positions sampled at the stamped times follow the jitter
of the stamps, positions sampled by a steady clock do not.
"""

from dataclasses import dataclass

import numpy as np

from lagrangian_ff.arrays import Floats, Ints
from lagrangian_ff.recording.recording import Recording, publishers
from lagrangian_ff.recording.splines import smooth

_STEADY = 10  # stamps in order before and after a fall that make it a clock set back
_RESET = 1.0  # s, smaller falls are samples out of order
_TOO_CLOSE = 0.1  # of a period: nearer stamps are one sample repeated

ON_THE_TICK = 1e-3
"""Of a period: stamps this near a uniform clock are on it."""

_WINDOW = 9  # samples; a delay that lasts shorter than half of them is no lost sample
_RUN = 100  # samples; shorter stretches are left as they are
_PAUSE = 10  # periods; a longer pause starts another stretch
_DRIFT = 10.0  # s; slower departures from a line are drift between clocks, not jitter
_CERTAIN = 0.25  # standard error of the slope below which it decides
# A fourth difference: blind to motion smooth over five samples, not to jitter.
_ROUGH = np.array([1.0, -4.0, 6.0, -4.0, 1.0])


@dataclass(frozen=True)
class Ordered:
    """The samples of one signal in order of time.

    Attributes:
        index: (K,) samples, so that time[index] increases strictly.
        moved: samples that arrived after a later one.
        repeated: samples left out because an earlier one has their stamp, or nearly.
        period: s, the usual distance of two samples; NaN for fewer than two.
    """

    index: Ints
    moved: int
    repeated: int
    period: float


def order(time: Floats) -> Ordered:
    """Return sorted stamps without repeats; of equal stamps the first to arrive stays."""
    moved = int(np.sum(time < np.maximum.accumulate(time))) if len(time) else 0
    index = np.argsort(time, kind="stable") if moved else np.arange(len(time))
    step = np.diff(time[index])
    period = usual_period(step)
    fresh = np.concatenate([np.ones(min(len(time), 1), bool), step > 0])
    index, step = index[fresh], step[fresh[1:]]
    if not np.isnan(period):
        near = np.diff(time[index]) < _TOO_CLOSE * period
        if near.any():
            index = index[np.concatenate([[True], ~near])]
    return Ordered(index, moved, len(time) - len(index), period)


def usual_period(step: Floats) -> float:
    """Return the distance of neighbouring samples (s) of an ordered signal.

    The mean of the steps that lost no sample: those up to 1.5 times the median. For a steady
    clock this is its exact period, also where stamps jitter.
    """
    step = step[step > 0]
    if step.size == 0:
        return float("nan")
    median = np.median(step)
    whole = step[(step <= 1.5 * median) & (step >= _TOO_CLOSE * median)]
    return float(whole.mean()) if whole.size else float(median)


def clock_resets(time: Floats) -> Ints:
    """Return the first samples after the clock was set back.

    In contrast to samples out of order, stamps are in order on both sides of a fall of more than
    one second. (A restarted simulation, an adjusted system clock.)
    """
    step = np.diff(time)
    falls = np.flatnonzero(step < -_RESET) + 1
    return np.array(
        [
            at
            for at in falls
            if _STEADY <= at <= len(time) - _STEADY
            and (step[at - _STEADY : at - 1] >= 0).all()
            and (step[at : at + _STEADY - 1] >= 0).all()
            # A single stamp that is far off looks like a fall, too.
            and np.median(time[at : at + _STEADY]) < np.median(time[at - _STEADY : at])
        ],
        dtype=np.int64,
    )


def without_resets(time: Floats) -> tuple[Floats, Ints]:
    """Return stamps that continue after each reset, and the resets.

    The pause between them is made one second, so that it counts as a gap.
    """
    resets = clock_resets(time)
    if resets.size == 0:
        return time, resets
    time = time.copy()
    for at in resets:
        time[at:] += time[:at].max() + _RESET - time[at:].min()
    return time, resets


@dataclass(frozen=True)
class Steadied:
    """Stamps, and those of a steady clock.

    Attributes:
        time: (K,) s, as stamped, increasing strictly.
        steady: (K,) s, increasing strictly.
        run: (K,) number of the stretch; -1 where a stretch was too short.
    """

    time: Floats
    steady: Floats
    run: Ints

    @property
    def jitter(self) -> float:
        """Return the largest departure of a stamp, s."""
        return float(np.abs(self.time - self.steady).max(initial=0.0))

    def apply(self, time: Floats) -> Floats:
        """Return any stamps (s) of the same clock, in any order, corrected."""
        if len(self.time) == 0:
            return time
        return time + np.interp(time, self.time, self.steady - self.time)


def steady_clock(time: Floats, period: float) -> Steadied:
    """Return the stamps of a steady clock of about this period.

    Args:
        time: (K,) s, increasing strictly.
    """
    steady = time.copy()
    run = np.full(len(time), -1, dtype=np.int64)
    edges = np.flatnonzero(np.diff(time) > _PAUSE * period) + 1
    for number, rows in enumerate(np.split(np.arange(len(time)), edges)):
        if len(rows) >= _RUN:
            fitted = _fit(time[rows], period)
            if (np.diff(fitted) > 0).all():
                steady[rows] = fitted
                run[rows] = number
    return Steadied(time, steady, run)


def _fit(time: Floats, period: float) -> Floats:
    index = np.arange(len(time), dtype=np.float64)
    # Lost samples lift all later stamps, so that they show behind a median; late ones do not.
    lasting = _median(time - period * index)
    index += np.concatenate([[0.0], np.cumsum(np.round(np.diff(lasting) / period))])
    lasting = _median(time - period * index)
    pieces = min(int((time[-1] - time[0]) / _DRIFT), len(time) // _RUN)
    if pieces < 2:
        drift = np.polynomial.Polynomial.fit(index, lasting, 1)(index)
    else:
        drift = smooth(index, lasting, pieces)
    return np.asarray(period * index + drift)


def _median(values: Floats) -> Floats:
    padded = np.pad(values, _WINDOW // 2, mode="edge")
    return np.asarray(np.median(np.lib.stride_tricks.sliding_window_view(padded, _WINDOW), axis=1))


def follows_stamps(clock: Steadied, position: Floats, period: float) -> bool:
    """Return whether the positions (K, N) were sampled at the stamped times.

    The fourth difference of position is regressed on that of velocity × jitter: the slope is
    1 if the stamps are right, 0 if a steady clock is. True also if the data cannot decide,
    since then it does not matter.
    """
    jitter = clock.time - clock.steady
    # Differences may not cross a lost sample or the edge of a stretch.
    step = np.diff(clock.steady)
    even = (np.abs(step / period - 1) < 0.1) & (clock.run[1:] >= 0)
    inside = np.convolve(even, np.ones(4), mode="valid") == 4
    if inside.sum() < _RUN:
        return True
    numerator = denominator = 0.0
    for joint in range(position.shape[1]):
        values = position[:, joint]
        velocity = np.gradient(values, clock.steady)
        smooth = np.convolve(velocity, np.ones(_WINDOW) / _WINDOW, mode="same")
        expected = np.convolve(smooth * jitter, _ROUGH, mode="valid")[inside]
        found = np.convolve(values, _ROUGH, mode="valid")[inside]
        spread = float(np.var(found))
        if spread > 0:
            numerator += float(expected @ found) / spread
            denominator += float(expected @ expected) / spread
    if denominator * _CERTAIN**2 < 1:
        return True
    return numerator / denominator > 0.5


def retime(recording: Recording, time: Floats, mode: str, notes: list[str]) -> Floats:
    """Return the stamps (M,) of a recording, or those of a steady clock if the motion follows it.

    Args:
        time: (M,) s, the stamps.
        mode: "auto" decides by the motion, "stamps" keeps them, "steady" replaces them.
    """
    if mode == "stamps":
        return time
    corrected = time.copy()
    for publisher in publishers(recording):
        rows, joints = publisher.rows, publisher.joints
        known = rows[np.isfinite(recording.position[np.ix_(rows, joints)]).all(axis=1)]
        ordered = order(time[known])
        if len(ordered.index) < _RUN or ordered.period > _DRIFT / _RUN:
            continue
        kept = known[ordered.index]
        clock = steady_clock(time[kept], ordered.period)
        if clock.jitter <= ON_THE_TICK * ordered.period:
            continue
        position = recording.position[np.ix_(kept, joints)]
        if mode == "steady" or not follows_stamps(clock, position, ordered.period):
            corrected[rows] = clock.apply(time[rows])
            notes.append(
                f"stamps jitter by up to {clock.jitter * 1e3:.3g} ms, which the motion does not "
                "follow: samples are taken to be those of a steady clock"
                if mode == "auto"
                else f"stamps, up to {clock.jitter * 1e3:.3g} ms off, are replaced by those of a "
                "steady clock"
            )
    return corrected
