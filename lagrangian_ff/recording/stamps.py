"""Time stamps as they come: unordered, repeated, with gaps, or set back."""

from dataclasses import dataclass

import numpy as np

from lagrangian_ff.arrays import Floats, Ints

_STEADY = 10  # stamps in order before and after a fall that make it a clock set back
RESET = 1.0
"""s, smaller falls are samples out of order; the pause put where a clock was set back."""

_TOO_CLOSE = 0.1  # of a period: nearer stamps are one sample repeated
_ROUNDING = 1e-9  # rad; smaller changes of a position are rounding


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
    falls = np.flatnonzero(step < -RESET) + 1
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
        time[at:] += time[:at].max() + RESET - time[at:].min()
    return time, resets


def least_distance(position: Floats) -> Floats:
    """Return (N,) rad, the least distance of two positions (K, N); 0 for a joint that stands."""
    found = np.zeros(position.shape[1])
    for joint, values in enumerate(position.T):
        apart = np.diff(np.unique(values))
        found[joint] = min(apart[apart > _ROUNDING], default=0.0)
    return found
