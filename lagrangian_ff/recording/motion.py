"""A recording made ready for identification, on one clock; and the settings that make it so."""

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace

import numpy as np

from lagrangian_ff.arrays import Flags, Floats, Ints
from lagrangian_ff.errors import RecordingError
from lagrangian_ff.recording.recording import columns_of, require_tables

_BY_JOINT = ("q", "qd", "qdd", "tau")
_BY_SAMPLE = ("time", *_BY_JOINT, "segment")
CLOCKS = ("auto", "stamps", "steady")
SCALINGS = ("effort_scale", "effort_offset")
"""Settings of each joint."""


@dataclass(frozen=True)
class Conditioning:
    """Settings of conditioning.

    Attributes:
        bandwidth: Hz, of the low-pass; reduced to a quarter of the sampling rate if need be.
        order: of the Butterworth low-pass.
        rate: Hz, of the resulting motion; None keeps the rate of the recording.
        max_gap: s, longer pauses of a signal end a segment, shorter ones are interpolated;
            None takes the longer of half a period of the bandwidth and 2.5 samples.
        trim: s, cut off at both ends of a segment, where the filter extrapolates; None takes the
            time in which it settles to 1/1000.
        clock: "stamps" trusts the stamps, "steady" assumes a steady clock and late stamps, "auto"
            decides by which of the two the motion follows.
        effort_scale: by joint, N·m per unit of effort; 1 for joints not named.
        effort_offset: by joint, N·m, added after scaling; 0 for joints not named.
    """

    bandwidth: float = 25.0
    order: int = 3
    rate: float | None = None
    max_gap: float | None = None
    trim: float | None = None
    clock: str = "auto"
    effort_scale: Mapping[str, float] = field(default_factory=dict)
    effort_offset: Mapping[str, float] = field(default_factory=dict)

    def __post_init__(self) -> None:
        for name in ("bandwidth", "rate", "max_gap"):
            value = getattr(self, name)
            if value is not None and not (np.isfinite(value) and value > 0):
                raise RecordingError(f"conditioning: {name} is {value}, expected more than 0")
        if self.clock not in CLOCKS:
            raise RecordingError(
                f"conditioning: clock is {self.clock!r}, expected one of {', '.join(CLOCKS)}"
            )
        if self.order < 1:
            raise RecordingError(f"conditioning: order is {self.order}, expected 1 or more")
        if self.trim is not None and not (np.isfinite(self.trim) and self.trim >= 0):
            raise RecordingError(f"conditioning: trim is {self.trim}, expected 0 or more")
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

    def __post_init__(self) -> None:
        tables = {name: getattr(self, name) for name in _BY_JOINT}
        require_tables(self.source, (len(self), len(self.joints)), tables)
        if self.segment.shape != self.time.shape:
            raise RecordingError(
                f"{self.source}: segment has shape {self.segment.shape}, expected {self.time.shape}"
            )

    def __len__(self) -> int:
        return int(self.time.shape[0])

    def take(self, index: "Ints | Flags | slice") -> "Motion":
        """Return the samples at these indices, in the order given."""
        return replace(self, **{name: getattr(self, name)[index] for name in _BY_SAMPLE})

    def select(self, joints: Sequence[str]) -> "Motion":
        """Return the motion of these joints, in this order.

        Raises:
            RecordingError: a joint is not in the motion; names both lists.
        """
        columns = columns_of(joints, self.joints, self.source)
        tables = {name: getattr(self, name)[:, columns] for name in _BY_JOINT}
        return replace(self, joints=tuple(joints), **tables)

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
        RecordingError: none was given, or they are of different joints.
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
    )
