"""A recording made ready for identification: q, qd, qdd and tau on one clock."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from lagrangian_ff.arrays import Flags, Floats, Ints
from lagrangian_ff.errors import RecordingError
from lagrangian_ff.recording.recording import columns_of, require_tables

_BY_JOINT = ("q", "qd", "qdd", "tau")
_BY_SAMPLE = ("time", *_BY_JOINT, "segment")


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
