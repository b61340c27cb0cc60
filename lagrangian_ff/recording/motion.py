"""A recording made ready for identification, on one clock; and the settings that make it so."""

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np

from lagrangian_ff.arrays import Flags, Floats, Ints
from lagrangian_ff.errors import RecordingError
from lagrangian_ff.recording.recording import columns_of, require_tables
from lagrangian_ff.recording.rest import at_rest
from lagrangian_ff.recording.units import checked_units

_BY_JOINT = ("q", "qd", "qdd", "tau")
CLOCKS = ("auto", "stamps", "steady")
SCALINGS = ("effort_scale", "effort_offset")
"""Settings of each joint."""
LONGEST_DELAY = 0.05
"""s; the effort of a driver that is later is another motion's."""
TOTAL, WITHOUT_GRAVITY, WITHOUT_FRICTION = EFFORTS = (
    "total",
    "without-gravity",
    "without-friction",
)
"""What the recorded effort holds: all torque, or all but what the driver or drive compensates."""


@dataclass(frozen=True)
class Conditioning:
    """Settings of conditioning.

    Attributes:
        bandwidth: Hz, of the low-pass; reduced to a quarter of the sampling rate if need be. None
            chooses it from the motion and its torque, and the motion's record has the number.
        order: of the Butterworth low-pass.
        rate: Hz, of the resulting motion; None keeps the rate of the recording.
        max_gap: s, longer pauses of a signal end a segment, shorter ones are interpolated;
            None takes the longer of half a period of the bandwidth and 2.5 samples.
        trim: s, cut off at both ends of a segment, where the filter extrapolates; None takes the
            time in which it settles to 1/1000.
        clock: "stamps" trusts the stamps, "steady" assumes a steady clock and late stamps, "auto"
            decides by which of the two the motion follows, and undoes steps of the clock.
        effort_scale: by joint, N·m per unit of effort; 1 for joints not named.
        effort_offset: by joint, N·m, added after scaling; 0 for joints not named.
        effort_delay: s by which the effort comes later than the position; negative if earlier.
        effort: what the effort holds, one of `EFFORTS`.
        units: by quantity (time, position, velocity, effort) what was recorded, as in
            `units.UNITS`; s, rad, rad/s and N·m for those not named.
    """

    bandwidth: float | None = None
    order: int = 3
    rate: float | None = None
    max_gap: float | None = None
    trim: float | None = None
    clock: str = "auto"
    effort_scale: Mapping[str, float] = field(default_factory=dict)
    effort_offset: Mapping[str, float] = field(default_factory=dict)
    effort_delay: float = 0.0
    effort: str = TOTAL
    units: Mapping[str, str] = field(default_factory=dict)

    def __post_init__(self) -> None:
        for name in ("bandwidth", "rate", "max_gap"):
            value = getattr(self, name)
            if value is not None and not (np.isfinite(value) and value > 0):
                raise RecordingError(f"conditioning: {name} is {value}, expected more than 0")
        if self.clock not in CLOCKS:
            raise RecordingError(
                f"conditioning: clock is {self.clock!r}, expected one of {', '.join(CLOCKS)}"
            )
        if self.effort not in EFFORTS:
            raise RecordingError(
                f"conditioning: effort is {self.effort!r}, expected one of {', '.join(EFFORTS)}"
            )
        if self.order < 1:
            raise RecordingError(f"conditioning: order is {self.order}, expected 1 or more")
        if not abs(self.effort_delay) <= LONGEST_DELAY:
            raise RecordingError(
                f"conditioning: effort_delay is {self.effort_delay} s, expected at most "
                f"{LONGEST_DELAY:g} s either way"
            )
        if self.trim is not None and not (np.isfinite(self.trim) and self.trim >= 0):
            raise RecordingError(f"conditioning: trim is {self.trim}, expected 0 or more")
        object.__setattr__(self, "units", checked_units(self.units))
        for name in SCALINGS:
            for joint, value in getattr(self, name).items():
                if not np.isfinite(value):
                    raise RecordingError(f"conditioning: {name} of {joint} is {value}")

    def record(self) -> dict[str, object]:
        """Return the settings for a model's record, so that other recordings are treated alike."""
        return {
            name: dict(value) if isinstance(value, Mapping) else value
            for name, value in asdict(self).items()
        }

    @classmethod
    def from_record(cls, record: object) -> "Conditioning | None":
        """Return the settings of a record; None if it has none, or those of another version."""
        if not isinstance(record, dict) or not record:
            return None
        try:
            return cls(**record)
        except TypeError:
            return None


@dataclass(frozen=True)
class Motion:
    """States and torques of N joints at M samples.

    Attributes:
        joints: N joint names; the columns of every array follow them.
        time: (M,) s, increasing within a segment.
        q: (M, N) rad.  qd: (M, N) rad/s.  qdd: (M, N) rad/s².
        tau: (M, N) N·m, the torque of the actuators.
        segment: (M,) samples recorded without interruption share a number, and numbers never
            decrease: nothing may be differentiated or correlated across a change.
        source: where it came from, for messages.
        notes: remarks of the reader and of conditioning, in words.
        conditioning: its settings, so that other recordings can be treated alike.
        temperature: (M, N) °C of each joint; NaN where it was not measured, None if none was.
        closely: (M,) samples that a diagnosis looks at more closely than at the others, since they
            were recorded for its question; None if all are alike.
    """

    joints: tuple[str, ...]
    time: Floats
    q: Floats
    qd: Floats
    qdd: Floats
    tau: Floats
    segment: Ints
    source: str = "memory"
    notes: tuple[str, ...] = ()
    conditioning: Mapping[str, object] = field(default_factory=dict)
    temperature: Floats | None = None
    closely: Flags | None = None

    def __post_init__(self) -> None:
        tables = self._tables
        require_tables(self.source, (len(self), len(self.joints)), tables)
        if self.segment.shape != self.time.shape:
            raise RecordingError(
                f"{self.source}: segment has shape {self.segment.shape}, expected {self.time.shape}"
            )

    def __len__(self) -> int:
        return int(self.time.shape[0])

    @property
    def effort(self) -> str:
        """Return what its torque holds, one of `EFFORTS`; total where nothing is said of it."""
        return str(self.conditioning.get("effort", TOTAL))

    def take(self, index: "Ints | Flags | slice") -> "Motion":
        """Return the samples at these indices, in the order given."""
        part: dict[str, Any] = {name: table[index] for name, table in self._tables.items()}
        if self.closely is not None:
            part["closely"] = self.closely[index]
        return replace(self, time=self.time[index], segment=self.segment[index], **part)

    def select(self, joints: Sequence[str]) -> "Motion":
        """Return the motion of these joints, in this order.

        Raises:
            RecordingError: a joint is not in the motion; names both lists.
        """
        columns = columns_of(joints, self.joints, self.source)
        tables: dict[str, Any] = {name: one[:, columns] for name, one in self._tables.items()}
        return replace(self, joints=tuple(joints), **tables)

    @cached_property
    def rest(self) -> Flags:
        """Return (M, N) where each joint stands still, see `at_rest`."""
        return at_rest(self.time, self.q, self.segment)

    @property
    def _tables(self) -> dict[str, Floats]:
        """Return the tables (M, N) by name; that of the temperature only if there is one."""
        tables = {name: getattr(self, name) for name in _BY_JOINT}
        return tables if self.temperature is None else {**tables, "temperature": self.temperature}

    @property
    def elapsed(self) -> Floats:
        """Return (M,) s since the beginning; several recordings are put end to end."""
        out = self.time - self.time[:1]
        for k in np.flatnonzero(np.diff(self.time) < 0.0) + 1:
            out[k:] += out[k - 1] - out[k]
        return out

    def blocks(self, seconds: float) -> Ints:
        """Return (M,) the number of the block that each sample lies in.

        Blocks last `seconds` and never cross a segment; what is left at a segment's end joins the
        last block where it is shorter than half of one. The paper cross-validates in blocks of
        3 s because neighbouring samples of a motion are not independent (section IV-B).
        """
        number = np.empty(len(self), dtype=np.int64)
        first = 0
        for segment in np.unique(self.segment):
            inside = self.segment == segment
            elapsed = self.time[inside] - self.time[inside][0]
            last = max(0, round(float(elapsed[-1]) / seconds) - 1)
            within = np.minimum(np.floor(elapsed / seconds + 1e-9).astype(np.int64), last)
            number[inside] = first + within
            first = int(number[inside][-1]) + 1
        return number


def concatenate(motions: Sequence[Motion]) -> Motion:
    """Return one motion of several, one after the other, each keeping its own segments.

    Raises:
        RecordingError: none was given, they are of different joints, or their efforts hold
            different torques.
    """
    if not motions:
        raise RecordingError("expected at least one motion, got none")
    joints = motions[0].joints
    offset = 0
    segments = []
    for motion in motions:
        if set(motion.joints) != set(joints):
            raise RecordingError(
                f"{motion.source} holds the joints {', '.join(motion.joints)}, but "
                f"{motions[0].source} holds {', '.join(joints)}; select common joints first"
            )
        if motion.effort != motions[0].effort:
            raise RecordingError(
                f"the effort of {motion.source} is {motion.effort}, that of {motions[0].source} "
                f"is {motions[0].effort}: one model holds for one of them; read both with the same "
                "--effort, if they are from the same driver"
            )
        segments.append(motion.segment - motion.segment.min(initial=0) + offset)
        offset = int(segments[-1].max(initial=offset - 1)) + 1
    ordered = [motion.select(joints) for motion in motions]
    arrays = {n: np.concatenate([getattr(m, n) for m in ordered]) for n in ("time", *_BY_JOINT)}
    return Motion(
        joints=joints,
        **arrays,
        segment=np.concatenate(segments),
        source=", ".join(dict.fromkeys(m.source for m in motions)),
        notes=tuple(dict.fromkeys(note for m in motions for note in m.notes)),
        conditioning=ordered[0].conditioning,
        temperature=_temperatures(ordered),
        closely=_closely(ordered),
    )


def _closely(motions: Sequence[Motion]) -> Flags | None:
    """Return the samples (M,) of motions that are looked at closely; None if all are alike."""
    if all(motion.closely is None for motion in motions):
        return None
    parts = [np.zeros(len(m), bool) if m.closely is None else m.closely for m in motions]
    return np.concatenate(parts)


def _temperatures(motions: Sequence[Motion]) -> Floats | None:
    """Return the temperatures (M, N) of motions of the same joints; None if none has any."""
    if all(motion.temperature is None for motion in motions):
        return None
    parts = [
        np.full(m.q.shape, np.nan) if m.temperature is None else m.temperature for m in motions
    ]
    return np.concatenate(parts)
