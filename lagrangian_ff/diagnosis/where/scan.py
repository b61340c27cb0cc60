"""The interval of one coordinate, or of two together, that stands out most by its error.

What stands out is measured by the divergence of Bernoulli(share of error) from Bernoulli(share of
time), the likelihood ratio of Kulldorff's scan statistic (1997): much error in little time.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lagrangian_ff.diagnosis.where.bins import divide
from lagrangian_ff.diagnosis.where.coordinates import COORDINATES, Coordinate
from lagrangian_ff.diagnosis.where.course import Course

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

ALONE, TOGETHER = 20, 8
"""Bins of a coordinate that is looked at alone, and of one that is looked at with another."""
LEAST_TIME, MOST_TIME = 0.01, 0.5
"""The share of the time that a region may hold."""


@dataclass(frozen=True)
class Axis:
    """One coordinate of a scan: its bins, and the intervals made of neighbouring ones.

    Attributes:
        coordinate: which.
        code: (M,) the bin of each sample, -1 for none.
        low, high: (K,) the ends of the bins.
        intervals: (I, 2) first and last bin of each interval; never all bins.
    """

    coordinate: Coordinate
    code: Ints
    low: Floats
    high: Floats
    intervals: Ints

    @classmethod
    def of(cls, course: Course, joint: int, name: str, count: int) -> "Axis | None":
        """None where the coordinate does not vary."""
        coordinate = COORDINATES[name]
        code, low, high = divide(coordinate, coordinate.values(course, joint), count)
        size = len(low)
        if not size:
            return None
        whole = bool((code >= 0).all())
        intervals = [
            (i, j)
            for i in range(size)
            for j in range(i, i + 1 if coordinate.levels else size)
            if not (whole and j - i == size - 1)
        ]
        return cls(coordinate, code, low, high, np.array(intervals, dtype=np.int64))

    @property
    def members(self) -> Floats:
        """(I, K) 1 where an interval holds a bin."""
        bins = np.arange(len(self.low))
        first, last = self.intervals[:, :1], self.intervals[:, 1:]
        return ((bins >= first) & (bins <= last)).astype(np.float64)

    def ends(self, interval: int) -> tuple[float, float]:
        """The low and the high end of an interval."""
        first, last = self.intervals[interval]
        return float(self.low[first]), float(self.high[last])


@dataclass(frozen=True)
class Found:
    """The most striking region of a scan.

    Attributes:
        strength: its divergence.
        ends: of each coordinate.
    """

    strength: float
    ends: tuple[tuple[float, float], ...]


@dataclass(frozen=True)
class Scan:
    """All intervals of a coordinate, or all rectangles of two."""

    axes: tuple[Axis, ...]

    @classmethod
    def of(cls, course: Course, joint: int, names: Sequence[str]) -> "Scan | None":
        """None where a coordinate does not vary."""
        count = ALONE if len(names) == 1 else TOGETHER
        axes = [Axis.of(course, joint, name, count) for name in names]
        found = tuple(axis for axis in axes if axis is not None)
        return cls(found) if len(found) == len(names) else None

    def strength(self, error: Floats) -> Floats:
        """(S, I1, I2) the divergence of each region for (S, M) squared errors, 0 where less
        error than time or too little or too much time."""
        code, other = self.axes[0].code, self.axes[-1].code
        rows, columns = len(self.axes[0].low), len(self.axes[-1].low)
        both = np.where((code >= 0) & (other >= 0), code * columns + other, -1)
        if len(self.axes) == 1:
            columns, both = 1, code
        kept = both >= 0
        place = both[kept]
        size = rows * columns
        time = np.bincount(place, minlength=size) / len(code)
        repeats = len(error)
        offset = (np.arange(repeats) * size)[:, None]
        counted = error if kept.all() else error[:, kept]
        energy = np.bincount((place + offset).ravel(), counted.ravel(), minlength=repeats * size)
        energy = energy.reshape(repeats, size) / np.maximum(error.sum(axis=1), 1e-300)[:, None]
        left = self.axes[0].members
        right = self.axes[1].members if len(self.axes) == 2 else np.ones((1, 1))
        shares = left @ energy.reshape(repeats, rows, columns) @ right.T
        times = left @ time.reshape(rows, columns) @ right.T
        return divergence(shares, times)

    def best(self, error: Floats) -> Found:
        """The most striking region for (M,) squared errors."""
        strength = self.strength(error[None])[0]
        place = np.unravel_index(int(np.argmax(strength)), strength.shape)
        ends = tuple(axis.ends(int(k)) for axis, k in zip(self.axes, place, strict=False))
        return Found(float(strength[place]), ends)

    def by_chance(self, shuffled: Floats) -> Floats:
        """(S,) the strength of the best region for (S, M) errors not tied to the motion."""
        return self.strength(shuffled).max(axis=(1, 2))


def divergence(share: Floats, time: Floats) -> Floats:
    """The divergence of Bernoulli(share) from Bernoulli(time)."""
    usable = (time >= LEAST_TIME) & (time <= MOST_TIME)
    found = np.zeros(np.broadcast_shapes(np.shape(share), np.shape(time)))
    t, e = time[usable], np.clip(share[..., usable], 1e-12, 1.0 - 1e-12)
    told = e * np.log(e / t) + (1.0 - e) * np.log((1.0 - e) / (1.0 - t))
    found[..., usable] = np.where(e > t, told, 0.0)
    return found
