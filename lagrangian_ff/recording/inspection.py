"""What a recording holds and what is wrong with it, before anything is done to it."""

from dataclasses import asdict, dataclass

import numpy as np
from numpy.typing import NDArray

from lagrangian_ff.recording.publishers import publishers
from lagrangian_ff.recording.quantisation import clipped, resolution
from lagrangian_ff.recording.recording import Recording
from lagrangian_ff.recording.stamps import clock_resets, order
from lagrangian_ff.recording.words import counted

Floats = NDArray[np.float64]

_GAP = 1.75  # periods: more than one lost sample's distance less the jitter
_STILL = 1e-3  # rad
_SHOWN = 5  # gaps listed for people


@dataclass(frozen=True)
class Gap:
    """A pause of the whole recording: `at` and `length` in s."""

    at: float
    length: float


@dataclass(frozen=True)
class Missing:
    """Values a publisher of a joint did not give: how many, and when first (s)."""

    joint: str
    quantity: str
    samples: int
    of: int
    first: float

    def text(self) -> str:
        """One sentence."""
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
        """One sentence."""
        return (
            f"{self.joint}: effort rests at {self.value:.6g} for {self.share:.2%} of the time; "
            "it is clipped there"
        )


@dataclass(frozen=True)
class JointRange:
    """What one joint did.

    Attributes:
        low, high: rad.
        resolution: rad, the smallest step of its position; None where no step shows.
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
        jitter_p50, jitter_p99: s, how far the distances of samples depart from the period.
        gaps: pauses longer than 1.75 periods.
        duplicates: samples that repeat a stamp.
        out_of_order: samples that arrived after a later one.
        clock_resets: how often the clock was set back.
        joints: by joint, in the order of the recording.
        missing: values that are NaN; velocity only where it is there at times.
        clipping: efforts that rest at an extreme.
        notes: what the reader met.
    """

    source: str
    samples: int
    duration: float
    rate: float
    jitter_p50: float
    jitter_p99: float
    gaps: tuple[Gap, ...]
    duplicates: int
    out_of_order: int
    clock_resets: int
    joints: tuple[JointRange, ...]
    missing: tuple[Missing, ...]
    clipping: tuple[Clipping, ...]
    notes: tuple[str, ...]

    def record(self) -> dict[str, object]:
        """The same for JSON: only dicts, lists, texts, numbers and None."""
        return {name: _plain(value) for name, value in asdict(self).items()}

    def lines(self) -> list[str]:
        """The same for people."""
        found = [
            self.source,
            f"  {self.samples} samples in {self.duration:.3f} s, {self.rate:.6g} Hz; "
            f"jitter {self.jitter_p50 * 1e6:.0f} µs (half of the samples), "
            f"{self.jitter_p99 * 1e6:.0f} µs (99 %)",
        ]
        for joint in self.joints:
            step = (
                "no encoder step seen"
                if joint.resolution is None
                else f"encoder step {joint.resolution:.3g} rad"
            )
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
        found += [f"  {entry.text()}" for entry in self.clipping]
        return found + [f"  note: {note}" for note in self.notes]


def inspect(recording: Recording) -> Inspection:
    """Look at a recording as it came; nothing is changed and nothing is an error."""
    sources = publishers(recording)
    rows = max((source.rows for source in sources), key=len, default=np.arange(len(recording)))
    time = recording.time[rows if len(rows) else slice(None)]
    ordered = order(time)
    steady = time[ordered.index]
    step = np.diff(steady)
    period = ordered.period
    deviation = np.abs(step - np.median(step)) if step.size else np.array([np.nan])
    at = np.flatnonzero(step > _GAP * period)
    return Inspection(
        source=recording.source,
        samples=len(recording),
        duration=float(np.ptp(recording.time)) if len(recording) else 0.0,
        rate=1 / period,
        jitter_p50=float(np.quantile(deviation, 0.5)),
        jitter_p99=float(np.quantile(deviation, 0.99)),
        gaps=tuple(Gap(float(steady[k]), float(step[k])) for k in at),
        duplicates=ordered.repeated,
        out_of_order=ordered.moved,
        clock_resets=len(clock_resets(recording.time)),
        joints=tuple(_joint(recording, column) for column in range(len(recording.joints))),
        missing=find_missing(recording),
        clipping=find_clipping(recording),
        notes=recording.notes,
    )


def find_clipping(recording: Recording) -> tuple[Clipping, ...]:
    """Efforts that rest at an extreme value."""
    return tuple(
        Clipping(joint, value, share)
        for column, joint in enumerate(recording.joints)
        for value, share in clipped(recording.effort[:, column])
    )


def find_missing(recording: Recording) -> tuple[Missing, ...]:
    """Values that are NaN in messages that tell of the joint's publisher."""
    found = []
    for publisher in publishers(recording):
        for column in publisher.joints:
            for quantity in ("position", "velocity", "effort"):
                lost = ~np.isfinite(getattr(recording, quantity)[publisher.rows, column])
                if lost.any() and not (quantity == "velocity" and lost.all()):
                    first = recording.time[publisher.rows[np.argmax(lost)]]
                    found.append(
                        Missing(
                            joint=recording.joints[column],
                            quantity=quantity,
                            samples=int(lost.sum()),
                            of=len(lost),
                            first=float(first),
                        )
                    )
    return tuple(found)


def _joint(recording: Recording, column: int) -> JointRange:
    position = recording.position[:, column]
    position = position[np.isfinite(position)]
    low, high = (
        (float(position.min()), float(position.max())) if position.size else (np.nan, np.nan)
    )
    return JointRange(
        name=recording.joints[column],
        low=low,
        high=high,
        resolution=resolution(position),
        velocity=bool(np.isfinite(recording.velocity[:, column]).any()),
        effort=bool(np.isfinite(recording.effort[:, column]).any()),
        still=bool(position.size and high - low < _STILL),
    )


def _plain(value: object) -> object:
    if isinstance(value, dict):
        return {key: _plain(inner) for key, inner in value.items()}
    if isinstance(value, (list, tuple)):
        return [_plain(inner) for inner in value]
    if isinstance(value, float) and not np.isfinite(value):
        return None
    return value
