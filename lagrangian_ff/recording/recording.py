"""Measured joint states, exactly as they came."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from lagrangian_ff import budget
from lagrangian_ff.arrays import Floats, Ints
from lagrangian_ff.errors import RecordingError

QUANTITIES = ("position", "velocity", "effort")
TEMPERATURE = "temperature"
"""A further quantity that few recordings have."""
_EPOCH = 1e8  # s; times above are dates (1973 and later), not seconds since start-up


def columns_of(wanted: Sequence[str], held: Sequence[str], source: str) -> list[int]:
    """Return the indices of the wanted joints among those that a source holds.

    Raises:
        RecordingError: one is not there; names both lists.
    """
    missing = [name for name in wanted if name not in held]
    if missing:
        raise RecordingError(f"{source}: no joint {', '.join(missing)}; it holds {', '.join(held)}")
    return [held.index(name) for name in wanted]


def require_joints(source: str, joints: int) -> None:
    """Raise RecordingError if a source holds more joints than any arm has."""
    if joints > budget.JOINTS:
        raise RecordingError(f"{source}: {joints} joints, expected at most {budget.JOINTS}")


def require_tables(source: str, shape: tuple[int, int], tables: Mapping[str, Floats]) -> None:
    """Raise RecordingError if one of the tables, by name, has not the shape (M, N)."""
    for name, table in tables.items():
        if table.shape != shape:
            raise RecordingError(
                f"{source}: {name} has shape {table.shape}, expected {shape} (samples, joints)"
            )


def require_times(source: str, time: Floats) -> None:
    """Raise RecordingError if a time (M,) is not a number."""
    bad = ~(np.abs(time) <= budget.LATEST)
    if bad.any():
        wrong = "not a number" if not np.isfinite(time).all() else f"beyond {budget.LATEST:g} s"
        raise RecordingError(
            f"{source}: time is {wrong} in {int(bad.sum())} samples, first in sample "
            f"{int(np.argmax(bad)) + 1} of {len(time)}"
        )


@dataclass(frozen=True)
class Recording:
    """Joint states as they were recorded: nothing sorted, filled, scaled or dropped.

    Attributes:
        joints: N joint names; the columns of every array follow them.
        time: (M,) seconds of each sample since `start`, from the message stamps, in order of
            arrival.
        position: (M, N) rad (m for prismatic joints).
        velocity: (M, N) rad/s; NaN where it was not given.
        effort: (M, N) in the driver's unit, N·m unless scaled later; NaN where it was not given.
        start: seconds since the Unix epoch of the first sample; 0 where unknown.
        source: the file or topic it came from, for messages.
        notes: remarks of the reader, in words.
        temperature: (M, N) °C of each joint; NaN where it was not given, None if it never was.
    """

    joints: tuple[str, ...]
    time: Floats
    position: Floats
    velocity: Floats
    effort: Floats
    start: float = 0.0
    source: str = "memory"
    notes: tuple[str, ...] = ()
    temperature: Floats | None = None

    def __post_init__(self) -> None:
        require_joints(self.source, len(self.joints))
        if len(set(self.joints)) != len(self.joints):
            raise RecordingError(f"{self.source}: a joint is named twice: {list(self.joints)}")
        tables = self.tables
        require_tables(self.source, (len(self), len(self.joints)), tables)

    def __len__(self) -> int:
        return int(self.time.shape[0])

    @property
    def tables(self) -> dict[str, Floats]:
        """Return the tables (M, N) by quantity; that of the temperature only if there is one."""
        tables = {name: getattr(self, name) for name in QUANTITIES}
        return tables if self.temperature is None else {**tables, TEMPERATURE: self.temperature}

    def select(self, joints: tuple[str, ...]) -> "Recording":
        """Return the recording of these joints, in this order.

        Raises:
            RecordingError: a joint is not in the recording; names both lists.
        """
        columns = columns_of(joints, self.joints, self.source)
        tables: dict[str, Any] = {name: one[:, columns] for name, one in self.tables.items()}
        return replace(self, joints=tuple(joints), **tables)


def from_arrays(
    path: Path,
    joints: list[str],
    time: Floats,
    tables: Sequence[Floats],
    start: float = 0.0,
    temperature: Floats | None = None,
) -> Recording:
    """Return a recording of a file; times (M,) that are dates are made relative.

    Args:
        tables: position, velocity and effort, (M, N) each.
        temperature: (M, N) °C, if there is any.

    Raises:
        RecordingError: a time is not a number, or shapes disagree.
    """
    require_times(str(path), time)
    if start == 0.0 and len(time) and time[0] > _EPOCH:
        start = float(time[0])
        time = time - start
    time = np.ascontiguousarray(time)
    position, velocity, effort = tables
    known = None if temperature is None or np.isnan(temperature).all() else temperature
    tables = position, velocity, effort
    return Recording(tuple(joints), time, *tables, start, str(path), temperature=known)


@dataclass(frozen=True)
class Publisher:
    """One of the nodes that publish on a topic, as the messages suggest.

    Attributes:
        rows: (K,) the samples it published.
        joints: (J,) the columns it gives values of.
    """

    rows: Ints
    joints: Ints


def publishers(recording: Recording) -> list[Publisher]:
    """Return the publishers: joints that share most of their messages have one publisher."""
    given = np.isfinite(recording.position) | np.isfinite(recording.effort)
    left = list(range(len(recording.joints)))
    found = []
    while left:
        first = given[:, left[0]]
        enough = np.count_nonzero(first) / 2
        common = [j for j in left if np.count_nonzero(given[:, j] & first) > enough] or left[:1]
        left = [joint for joint in left if joint not in common]
        joints = np.array(common, dtype=np.int64)
        found.append(Publisher(np.flatnonzero(given[:, joints].any(axis=1)), joints))
    return found
