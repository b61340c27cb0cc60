"""Time stamps as they come: out of order, repeated, with gaps, from a clock that was set back."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

_STEADY = 10  # stamps in order before and after a fall that make it a clock set back
_RESET = 1.0  # s, smaller falls are samples out of order
_TOO_CLOSE = 0.1  # of a period: nearer stamps are one sample told twice


@dataclass(frozen=True)
class Ordered:
    """The samples of one signal in order of time.

    Attributes:
        index: (K,) which samples, so that time[index] increases strictly.
        moved: samples that arrived after a later one.
        repeated: samples left out because an earlier one has their stamp, or nearly.
        period: s, the usual distance of two samples; NaN for fewer than two.
    """

    index: Ints
    moved: int
    repeated: int
    period: float


def order(time: Floats) -> Ordered:
    """Sort stamps and leave out repeats; of equal stamps the first to arrive stays."""
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
    """The distance of neighbouring samples (s) of an ordered signal.

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
    """Positions at which the clock was set back: the first sample of the new count.

    Told from samples out of order by its stamps: in order on both sides of a fall of more than
    one second. (A restarted simulation, an adjusted system clock.)
    """
    step = np.diff(time)
    falls = np.flatnonzero(step < -_RESET) + 1
    return np.array(
        [
            at
            for at in falls
            if at >= _STEADY
            and len(time) - at >= _STEADY
            and (step[at - _STEADY : at - 1] >= 0).all()
            and (step[at : at + _STEADY - 1] >= 0).all()
            # A single stamp that is far off looks like a fall, too.
            and np.median(time[at : at + _STEADY]) < np.median(time[at - _STEADY : at])
        ],
        dtype=np.int64,
    )


def without_resets(time: Floats) -> tuple[Floats, Ints]:
    """Stamps with what follows each reset moved behind what came before, and the resets.

    The pause between them is made one second, so that it counts as a gap.
    """
    resets = clock_resets(time)
    if resets.size == 0:
        return time, resets
    time = time.copy()
    for at in resets:
        time[at:] += time[:at].max() + _RESET - time[at:].min()
    return time, resets
