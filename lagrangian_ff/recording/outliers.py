"""Single samples that are no measurement: a flipped bit, a lost digit, a driver's default.

What an arm does lasts. Position, velocity and torque pass drives and gears, so that a peak, a
contact or a reversal shows in the samples beside it, and most changes stay. An outlier is one
sample, or two in a row, that leave their neighbours and return to them while these hardly change.
Three things must hold of its distance from the running median (Hampel's filter):

- it exceeds every change, from one sample to the next, that the signal makes elsewhere and keeps:
  the signal's own bandwidth does not allow it;
- it exceeds the noise of the signal by far;
- it exceeds the changes of the samples around it by far: a genuine peak, even one that lasts for a
  single sample, passes a low-pass of the drive and leaves a trace in its neighbours.

A torque of one sample that kicks the arm is genuine: no outlier of effort is where a joint
accelerates as it did not before, unless the torque is far beyond all others of the recording.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from lagrangian_ff.arrays import Flags, Floats, Ints
from lagrangian_ff.recording.recording import QUANTITIES, Recording
from lagrangian_ff.words import counted

LONGEST = 2
"""Samples in a row that an outlier may last."""
REACH = 3
"""Samples to either side of the running median: it ignores up to three, so also two outliers."""
AROUND = 8
"""Samples to either side whose changes count as what the signal does there."""
ALLOWED = 3.0
"""Times the largest change that the signal keeps."""
NOISE = 8.0
"""Times the distance from the running median within which 98 % lie: 20 standard deviations."""
BESIDE = 5.0
"""Times the largest change beside it."""
STEPS = 10.0
"""Times the smallest change that occurs, which is the step of a quantised signal."""
KICK = 1.5
"""Times the acceleration before it that shows that a torque was there."""
BEFORE, AFTER = 20, 6
"""Samples before an effort that a kick is compared with, and after it in which it shows."""
LAG = 3
"""Samples over which acceleration is differenced: over fewer, the encoder's steps hide it."""
BEYOND = 1.0
"""Times the range of all other efforts of the joint that no motion makes credible."""
RARE = 0.005
"""Share of the samples above which lone samples are how the signal is."""
FEWEST = 50
"""Samples below which a signal does not show what it allows."""
_USUAL, _KEPT = 0.98, 0.999
_SHOWN = 5


@dataclass(frozen=True)
class Outlier:
    """A sample that neither its neighbours nor the signal itself allow.

    Attributes:
        joint, quantity: what it was recorded of.
        sample: its row in the recording, from 0.
        time: s, its stamp.
        value: what was recorded, in the recording's unit.
        expected: the median of the samples around it.
    """

    joint: str
    quantity: str
    sample: int
    time: float
    value: float
    expected: float

    def text(self) -> str:
        """Return one sentence."""
        return (
            f"{self.joint}: {self.quantity} of {self.value:.4g} in sample {self.sample + 1} at "
            f"{self.time:.3f} s, where its neighbours lie around {self.expected:.4g}"
        )


def find_outliers(recording: Recording) -> tuple[Outlier, ...]:
    """Return the outliers of position, velocity and effort, by joint and time.

    Signals with more of them than `RARE` have none: lone samples are how they are.
    """
    found = []
    for column, joint in enumerate(recording.joints):
        for quantity in QUANTITIES:
            values = getattr(recording, quantity)[:, column]
            known = np.flatnonzero(np.isfinite(values))
            values = values[known]
            if len(values) < FEWEST or np.ptp(values) == 0.0:
                continue
            at, expected = _lone(values)
            if quantity == "effort" and len(at):
                kept = _incredible(recording, values, known, at)
                at, expected = at[kept], expected[kept]
            if len(at) > max(LONGEST, RARE * len(values)):
                continue
            for place, usual in zip(at, expected, strict=True):
                row = int(known[place])
                about = float(recording.time[row]), float(values[place]), float(usual)
                found.append(Outlier(joint, quantity, row, *about))
    return tuple(found)


def without_outliers(recording: Recording) -> tuple[Recording, list[str]]:
    """Return the recording with NaN in place of outliers, and what was left out, in words."""
    found = find_outliers(recording)
    return without(recording, found), [f"{text}; left out" for text in outlier_texts(found)]


def without(recording: Recording, outliers: Sequence[Outlier]) -> Recording:
    """Return the recording with NaN in place of these samples."""
    tables = {name: getattr(recording, name) for name in QUANTITIES}
    for name in {one.quantity for one in outliers}:
        tables[name] = tables[name].copy()
    columns = {joint: column for column, joint in enumerate(recording.joints)}
    for one in outliers:
        tables[one.quantity][one.sample, columns[one.joint]] = np.nan
    return replace(recording, **tables)


def outlier_texts(outliers: Sequence[Outlier]) -> list[str]:
    """Return a sentence for each of the first few outliers, and one for the rest."""
    texts = [one.text() for one in outliers[:_SHOWN]]
    rest = outliers[_SHOWN:]
    if rest:
        joints = ", ".join(dict.fromkeys(f"{one.quantity} of {one.joint}" for one in rest))
        texts.append(f"{counted(len(rest), 'more outlier')} ({joints})")
    return texts


@np.errstate(over="ignore", invalid="ignore")  # values near the largest number
def _lone(values: Floats) -> tuple[Ints, Floats]:
    """Return the places (C,) of outliers among values (K,), and the median around each."""
    padded = np.pad(values, REACH, mode="reflect")
    median = np.median(sliding_window_view(padded, 2 * REACH + 1), axis=1)
    away = np.abs(values - median)
    kept = np.abs(np.diff(median))
    least = max(ALLOWED * float(np.quantile(kept, _KEPT)), NOISE * float(np.quantile(away, _USUAL)))
    far = away > least
    if not far.any():
        return np.empty(0, dtype=np.int64), np.empty(0)
    usual = values[~far]
    change = np.abs(np.diff(usual))
    change = change[change > 0.0]
    # A signal that never changes otherwise has no step to compare with, but its own size.
    step = float(change.min()) if change.size else float(np.abs(usual).max(initial=0.0))
    far &= away > (STEPS if change.size else 1.0) * step
    ends = np.flatnonzero(np.diff(far, prepend=False, append=False))
    found = [
        np.arange(first, last)
        for first, last in ends.reshape(-1, 2)
        if last - first <= LONGEST
        and away[first:last].min() > BESIDE * _change_beside(values, far, first, last)
    ]
    at = np.concatenate(found) if found else np.empty(0, dtype=np.int64)
    return at, median[at]


def _incredible(recording: Recording, values: Floats, known: Ints, at: Ints) -> Flags:
    """Return (C,) whether efforts at these places are no torque that moved the arm.

    Args:
        values: (K,) efforts.  known: (K,) their rows in the recording.  at: (C,) places of them.
    """
    rest = np.delete(values, at)
    low, high = float(rest.min()), float(rest.max())
    reach = BEYOND * (high - low)
    beyond = (values[at] > high + reach) | (values[at] < low - reach)
    return np.array(
        [far or not _kicked(recording, int(known[k])) for far, k in zip(beyond, at, strict=True)]
    )


def _kicked(recording: Recording, row: int) -> bool:
    """Return whether a joint accelerates after this row as it did not before."""
    first = max(0, row - BEFORE - LAG)
    near = recording.position[first : row + AFTER + LAG + 1]
    hard = np.abs(near[2 * LAG :] - 2.0 * near[LAG:-LAG] + near[: -2 * LAG])
    split = row - first - 2 * LAG  # what lies before uses no sample after the row
    if split < LAG or len(hard) <= split:
        return False
    before, after = hard[:split], hard[split:]
    kicked = after.max(axis=0) > KICK * before.max(axis=0)
    return bool(kicked.any())  # NaN compares as False


def _change_beside(values: Floats, far: Flags, first: int, last: int) -> float:
    """Return the largest change among the samples before and after, others far away left out."""
    begin, end = max(0, first - AROUND), min(len(values), last + AROUND)
    near = values[begin:end][~far[begin:end]]
    return max((abs(float(b - a)) for a, b in pairwise(near)), default=np.inf)
