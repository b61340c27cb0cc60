"""The content of a recording, and its faults."""

from collections.abc import Sequence
from dataclasses import asdict, dataclass

import numpy as np

from lagrangian_ff.arrays import Flags, Floats, Ints
from lagrangian_ff.record_json import finite
from lagrangian_ff.recording.outliers import Outlier, find_outliers, outlier_texts, without
from lagrangian_ff.recording.recording import QUANTITIES, Recording, publishers
from lagrangian_ff.recording.stamps import clock_resets, order, usual_period
from lagrangian_ff.recording.units import Doubt, find_doubts
from lagrangian_ff.words import counted

_GAP = 1.75  # periods: more than one lost sample's distance less the jitter
_STILL = 1e-3  # rad
_SHOWN = 5  # gaps listed for people
_ROUNDING = 1e-12  # of the largest value: differences below are floating point
_MULTIPLE = 0.1  # of a step: how near to a multiple counts as one
_AGREEING = 0.98  # share of the differences that must be multiples
_FEWEST = 10  # differences to judge by
_REST = 3  # samples in a row at the extreme
# Times the longest rest on a value in between. A parabola's top step, quantised, lasts up to 4.8
# times as long as the step below on one side.
_LONGER = 6
_TOGETHER = 0.3  # of the mean step: half of the steps are shorter where samples share a stamp
_NO_GAP = 0.99  # share of the steps that are no gap
_AROUND = 5  # samples to either side over which a joint moves
_MOVED = 0.02  # of the most that it moves in that time


@dataclass(frozen=True)
class Gap:
    """A pause of the whole recording: `at` and `length` in s."""

    at: float
    length: float


@dataclass(frozen=True)
class Missing:
    """Values that a joint's publisher left out: their number, and the time of the first (s)."""

    joint: str
    quantity: str
    samples: int
    of: int
    first: float

    def text(self) -> str:
        """Return one sentence."""
        return (
            f"{self.joint}: no {self.quantity} in {self.samples} of {self.of} samples, first at "
            f"{self.first:.3f} s"
        )


@dataclass(frozen=True)
class Clipping:
    """An effort that rests at its extreme value for a share (0 to 1) of the time."""

    joint: str
    value: float
    share: float

    def text(self) -> str:
        """Return one sentence."""
        return (
            f"{self.joint}: effort rests at {self.value:.6g} for {self.share:.2%} of the time; "
            "it is clipped there"
        )


@dataclass(frozen=True)
class JointRange:
    """The motion of one joint.

    Attributes:
        low, high: rad.
        resolution: rad, the smallest step of its position; None if no step shows.
        velocity, effort: whether any was recorded.
        still: it moved less than 1e-3 rad.
    """

    name: str
    low: float
    high: float
    resolution: float | None
    velocity: bool
    effort: bool
    still: bool


@dataclass(frozen=True)
class Inspection:
    """Findings on a recording.

    Attributes:
        source: file and topic.
        samples: number of messages or rows.
        duration: s.
        rate: Hz; NaN for fewer than two samples.
        batch: how many samples are stamped together, as they arrived; 1 where each has its stamp.
        jitter_p50, jitter_p99: s, how far the distances of samples depart from the period.
        gaps: pauses longer than 1.75 periods.
        duplicates: samples that repeat a stamp.
        out_of_order: samples that arrived after a later one.
        clock_resets: how often the clock was set back.
        joints: by joint, in the order of the recording.
        missing: values that are NaN; velocity only where it is there at times.
        outliers: single samples that neither their neighbours nor the signal allow.
        clipping: efforts that rest at an extreme.
        doubts: quantities that contradict each other, such as another unit.
        notes: remarks of the reader.
    """

    source: str
    samples: int
    duration: float
    rate: float
    batch: int
    jitter_p50: float
    jitter_p99: float
    gaps: tuple[Gap, ...]
    duplicates: int
    out_of_order: int
    clock_resets: int
    joints: tuple[JointRange, ...]
    missing: tuple[Missing, ...]
    outliers: tuple[Outlier, ...]
    clipping: tuple[Clipping, ...]
    doubts: tuple[Doubt, ...]
    notes: tuple[str, ...]

    def record(self) -> dict[str, object]:
        """Return the findings for JSON: only dicts, lists, texts, numbers and None."""
        return finite(asdict(self))

    def lines(self) -> list[str]:
        """Return the findings for people."""
        found = [
            self.source,
            f"  {self.samples} samples in {self.duration:.3f} s, {self.rate:.6g} Hz; "
            + (f"stamped together in batches of {self.batch}; " if self.batch > 1 else "")
            + f"jitter {self.jitter_p50 * 1e6:.0f} µs (half of the samples), "
            f"{self.jitter_p99 * 1e6:.0f} µs (99 %)",
        ]
        for joint in self.joints:
            size = joint.resolution
            step = "no encoder step seen" if size is None else f"encoder step {size:.3g} rad"
            lacking = [name for name in ("velocity", "effort") if not getattr(joint, name)]
            found.append(
                f"  {joint.name}: {joint.low:.3f} to {joint.high:.3f} rad, {step}"
                + (", stands still" if joint.still else "")
                + "".join(f", no {name}" for name in lacking)
            )
        if self.gaps:
            longest = sorted(self.gaps, key=lambda gap: -gap.length)[:_SHOWN]
            shown = ", ".join(
                f"{gap.length * 1e3:.4g} ms at {gap.at:.3f} s"
                for gap in sorted(longest, key=lambda gap: gap.at)
            )
            first = f", the {_SHOWN} longest" if len(self.gaps) > _SHOWN else ""
            found.append(f"  {counted(len(self.gaps), 'gap')}{first}: {shown}")
        found += [
            f"  {text}"
            for number, text in (
                (self.duplicates, f"stamps repeated by {counted(self.duplicates, 'sample')}"),
                (self.out_of_order, f"{counted(self.out_of_order, 'sample')} arrived out of order"),
                (self.clock_resets, f"clock set back {counted(self.clock_resets, 'time')}"),
            )
            if number
        ]
        found += [f"  {entry.text()}" for entry in self.missing]
        found += [f"  {text}" for text in outlier_texts(self.outliers)]
        found += [f"  {text}" for text in _texts(self.doubts, self.clipping)]
        return found + [f"  note: {note}" for note in self.notes]


def _texts(doubts: Sequence[Doubt], clipping: Sequence[Clipping]) -> list[str]:
    return [*(one.text() for one in doubts), *(one.text() for one in clipping)]


@np.errstate(over="ignore", invalid="ignore", divide="ignore")
def inspect(recording: Recording) -> Inspection:
    """Return the findings on a recording as it came; it is not changed, nothing is an error."""
    outliers = find_outliers(recording)
    sound = without(recording, outliers)
    sources = publishers(recording)
    rows = max((source.rows for source in sources), key=len, default=np.arange(len(recording)))
    time = recording.time[rows if len(rows) else slice(None)]
    ordered = order(time)
    steady = time[ordered.index]
    step = np.diff(steady)
    period, first = ordered.period, _first_of_batches(step)
    batch = round(float(np.median(np.diff(first)))) if len(first) > 1 else 1
    if batch > 1:
        steady, step = steady[first], np.diff(steady[first])
        period = usual_period(step) / batch
    deviation = np.abs(step - np.median(step)) if step.size else np.array([np.nan])
    at = np.flatnonzero(step > _GAP * period * batch)
    return Inspection(
        source=recording.source,
        samples=len(recording),
        duration=float(np.ptp(recording.time)) if len(recording) else 0.0,
        rate=1 / period,
        batch=batch,
        jitter_p50=float(np.quantile(deviation, 0.5)),
        jitter_p99=float(np.quantile(deviation, 0.99)),
        gaps=tuple(Gap(float(steady[k]), float(step[k])) for k in at),
        duplicates=ordered.repeated,
        out_of_order=ordered.moved,
        clock_resets=len(clock_resets(recording.time)),
        joints=tuple(_joint(recording, column) for column in range(len(recording.joints))),
        missing=find_missing(recording),
        outliers=outliers,
        clipping=find_clipping(sound),
        doubts=find_doubts(sound),
        notes=recording.notes,
    )


def _first_of_batches(step: Floats) -> Ints:
    """Return the first sample of each batch that is stamped together; nothing if none is.

    Within a batch the stamps show no more than the order in which the samples arrived.
    """
    if step.size < _FEWEST:
        return np.empty(0, dtype=np.int64)
    mean = float(step[step <= np.quantile(step, _NO_GAP)].mean())
    if not np.median(step) < _TOGETHER * mean:
        return np.empty(0, dtype=np.int64)
    return np.concatenate([[0], np.flatnonzero(step > mean) + 1])


def find_clipping(recording: Recording) -> tuple[Clipping, ...]:
    """Return efforts that rest at an extreme value."""
    return tuple(
        Clipping(joint, value, share)
        for column, joint in enumerate(recording.joints)
        for value, share in clipped(
            recording.effort[:, column], _moving(recording.position[:, column])
        )
    )


def find_missing(recording: Recording) -> tuple[Missing, ...]:
    """Return values that are NaN in messages of the joint's publisher."""
    found = []
    for publisher in publishers(recording):
        for column in publisher.joints:
            for quantity in QUANTITIES:
                lost = ~np.isfinite(getattr(recording, quantity)[publisher.rows, column])
                if lost.any() and not (quantity == "velocity" and lost.all()):
                    first = recording.time[publisher.rows[np.argmax(lost)]]
                    name, count = recording.joints[column], int(lost.sum())
                    found.append(Missing(name, quantity, count, len(lost), float(first)))
    return tuple(found)


def _joint(recording: Recording, column: int) -> JointRange:
    position = recording.position[:, column]
    position = position[np.isfinite(position)]
    low, high = (position.min(), position.max()) if position.size else (np.nan, np.nan)
    return JointRange(
        name=recording.joints[column],
        low=float(low),
        high=float(high),
        resolution=resolution(position),
        velocity=bool(np.isfinite(recording.velocity[:, column]).any()),
        effort=bool(np.isfinite(recording.effort[:, column]).any()),
        still=bool(position.size and high - low < _STILL),
    )


def resolution(position: Floats) -> float | None:
    """Return the step of which the values are multiples (same unit); None if there is none.

    The smallest difference between distinct values, or a half or third of it, of which all
    small differences must be multiples; refined by dividing these by their numbers of steps.
    """
    values = np.unique(position[np.isfinite(position)])
    if values.size < 3:
        return None
    floor = _ROUNDING * max(np.abs(values).max(), 1.0)
    difference = np.diff(values)
    difference = np.sort(difference[difference > floor])
    for parts in (1, 2, 3):
        if difference.size and (step := _common_step(difference, difference[0] / parts)):
            return step
    return None


def _common_step(difference: Floats, step: float) -> float | None:
    """Return the step near this one of which the small differences (sorted) are multiples."""
    for reach in (4, 12, 40, 120):
        near = difference[difference < (reach + 0.5) * step]
        count = np.round(near / step)
        if near.size == 0 or count.min() < 1:
            return None
        step = float(near.sum() / count.sum())
    off = np.abs(near / step - np.round(near / step))
    agree = near.size >= _FEWEST and np.mean(off < _MULTIPLE) >= _AGREEING
    return step if agree else None


def clipped(effort: Floats, moving: Flags | None = None) -> list[tuple[float, float]]:
    """Return extreme values at which (M,) rests, each with its share of the samples.

    A clipped effort rests on its largest or smallest value exactly, and far longer than it rests
    on any other value while the joint moves. So neither a quantised effort with its round peaks,
    nor one that a driver repeats until the next, nor an arm that stands still is taken for
    clipped. Zero is no limit.

    Args:
        moving: (M,) whether the joint moves; None if it always does.
    """
    known = np.isfinite(effort)
    values = effort[known]
    if values.size < 10 * _REST or np.ptp(values) == 0:
        return []
    ends = np.flatnonzero(np.diff(values)) + 1
    first, last = np.concatenate([[0], ends]), np.concatenate([ends, [values.size]])
    length, value = last - first, values[first]
    if moving is not None:
        # A rest counts from when the joint moves until it stops.
        passed = np.concatenate([[0], np.cumsum(moving[known])])
        length = passed[last] - passed[first]
    found = []
    extremes = values.max(), values.min()
    between = length[(value != extremes[0]) & (value != extremes[1])]
    needed = max(_REST, _LONGER * int(between.max(initial=0)))
    for extreme in extremes:
        rests = (value == extreme) & (length >= needed)
        if extreme != 0.0 and rests.any():
            found.append((float(extreme), float(length[value == extreme].sum() / values.size)))
    return found


def _moving(position: Floats) -> Flags:
    """Return whether a joint moves at each sample (M,)."""
    step = np.zeros(len(position))
    if len(position) > 2 * _AROUND:
        step[_AROUND:-_AROUND] = np.abs(position[2 * _AROUND :] - position[: -2 * _AROUND])
    step = np.where(np.isfinite(step), step, 0.0)
    return np.asarray(step > _MOVED * step.max(initial=0.0))
