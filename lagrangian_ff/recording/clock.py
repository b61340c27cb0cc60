"""Whether stamps tell when samples were taken, or when a message happened to be made.

A driver samples with the robot's own steady clock and often stamps later, with a delay that
varies. Trusting such stamps shifts a moving joint by velocity × delay, and two differentiations
make large accelerations of it. The motion itself tells: positions sampled at the stamped times
follow the jitter of the stamps, positions sampled by a steady clock do not.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lagrangian_ff.recording.publishers import publishers
from lagrangian_ff.recording.recording import Recording
from lagrangian_ff.recording.splines import smooth
from lagrangian_ff.recording.stamps import order

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

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
class Steadied:
    """Stamps and what a steady clock would have stamped.

    Attributes:
        time: (K,) s, as stamped, increasing strictly.
        steady: (K,) s, increasing strictly.
        run: (K,) number of the stretch; -1 where a stretch was too short to tell.
    """

    time: Floats
    steady: Floats
    run: Ints

    @property
    def jitter(self) -> float:
        """s, the largest departure of a stamp."""
        return float(np.abs(self.time - self.steady).max(initial=0.0))

    def apply(self, time: Floats) -> Floats:
        """Correct any stamps (s) of the same clock, whatever their order."""
        if len(self.time) == 0:
            return time
        return time + np.interp(time, self.time, self.steady - self.time)


def steady_clock(time: Floats, period: float) -> Steadied:
    """What a steady clock of about this period would have stamped.

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
    """Whether the positions (K, N) were sampled at the stamped times.

    The fourth difference of position is regressed on that of velocity × jitter: the slope is
    1 where the stamps are right, 0 where a steady clock is. True also where the data cannot
    tell, because then it does not matter.
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
    """Stamps (M,) of a recording, replaced by a steady clock's where the motion tells so.

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
