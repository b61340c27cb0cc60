"""The few regions that hold most of a joint's error, in words.

A region is an interval of one coordinate, or of two together. The one that stands out most is found
by the divergence of Bernoulli(share of error) from Bernoulli(share of time), the likelihood ratio
of Kulldorff's scan statistic (1997): much error in little time.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from lagrangian_ff.arrays import Flags, Floats, Ints
from lagrangian_ff.diagnosis.where.bins import divide
from lagrangian_ff.diagnosis.where.coordinates import APART, COORDINATES, PAIRS, Coordinate, percent
from lagrangian_ff.diagnosis.where.series import (
    BLOCK_SECONDS,
    ResidualSeries,
    band,
    block_orders,
    resampled,
)
from lagrangian_ff.numbers import typeset

ALONE, TOGETHER = 20, 8
"""Bins of a coordinate that is looked at alone, and of one that is looked at with another."""
LEAST_TIME, MOST_TIME = 0.01, 0.5
"""The share of the time that a region may hold."""
SAMPLES = 6000
"""On which regions are searched; what they hold is then counted on all."""
MOST = 3
"""Regions named per joint."""
ENOUGH = 0.8
"""Share of the error: once regions hold it, no more are looked for."""
SHUFFLES = 100
CHANCE, CHANCE_OF_TIME = 0.05, 0.01
"""Probability that evenly spread error shows a region, and a region of time. The latter is smaller
because error comes and goes over more than a block."""
LEAST_RATIO, SURE_RATIO = 1.5, 1.2
"""Least share of error over share of time of a region, and least low end of that ratio's band."""
LEAST_SHARE = 0.1
PAIR_MUST_GAIN = 1.3
"""Two conditions are named only if they stand out by this factor more than the best single one."""
STATIC = 1.5
"""Static friction over Coulomb friction, at most."""
AS_GOOD = 0.9
"""A coordinate that is listed earlier is named if it reaches this share of the best."""


@dataclass(frozen=True)
class Condition:
    """An interval of one coordinate.

    Attributes:
        coordinate: its name.  low, high: the ends, both included.
        words: as in "below 0.1 rad/s".
    """

    coordinate: str
    low: float
    high: float
    words: str

    def holds(self, series: ResidualSeries, joint: int) -> Flags:
        """Return (M,) where it is met."""
        values = COORDINATES[self.coordinate].values(series, joint)
        with np.errstate(invalid="ignore"):
            return np.asarray((values >= self.low) & (values <= self.high))


@dataclass(frozen=True)
class Region:
    """A part of the motion that holds clearly more of a joint's error than of its time.

    Attributes:
        joint: its name.  conditions: one or two, all of them met.
        share_of_error: of the joint's squared error.
        band: 90 % of it, from a bootstrap over blocks of 1 s.
        share_of_time: of the samples.  rms: N·m, of the residual inside.
        remark: what follows from it, in words; mostly nothing.
    """

    joint: str
    conditions: tuple[Condition, ...]
    share_of_error: float
    band: tuple[float, float]
    share_of_time: float
    rms: float
    remark: str = ""

    @property
    def strength(self) -> float:
        """Return how much it stands out; see `divergence`."""
        share, time = np.array([self.share_of_error]), np.array([self.share_of_time])
        return float(divergence(share, time)[0])

    @property
    def place(self) -> str:
        """Its conditions in words, without the joint."""
        return " ".join(condition.words for condition in self.conditions)

    @property
    def words(self) -> str:
        """The region as one sentence."""
        return (
            f"{self.joint} {self.place}: {percent(self.share_of_error)} of its error in "
            f"{percent(self.share_of_time)} of the time{self.remark}"
        )

    def record(self) -> dict[str, object]:
        """Return the region for JSON: the first condition, and the other if there are two."""
        listed = [
            {"coordinate": c.coordinate, "low": c.low, "high": c.high} for c in self.conditions
        ]
        return {
            "joint": self.joint,
            **listed[0],
            "also": listed[1:],
            "share_of_error": self.share_of_error,
            "share_of_error_low": self.band[0],
            "share_of_error_high": self.band[1],
            "share_of_time": self.share_of_time,
            "rmse": self.rms,
            "place": self.place,
            "words": self.words,
        }


@dataclass(frozen=True)
class Axis:
    """One coordinate of a scan: its bins, and the intervals made of neighbouring ones.

    Attributes:
        coordinate: which.  code: (M,) the bin of each sample, -1 for none.
        low, high: (K,) the ends of the bins.
        intervals: (I, 2) first and last bin of each interval; never all bins.
    """

    coordinate: Coordinate
    code: Ints
    low: Floats
    high: Floats
    intervals: Ints

    @classmethod
    def of(cls, series: ResidualSeries, joint: int, name: str, count: int) -> "Axis | None":
        """Return the axis; None if the coordinate does not vary."""
        coordinate = COORDINATES[name]
        code, low, high = divide(coordinate, coordinate.values(series, joint), count)
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
        """Return (I, K), 1 where an interval holds a bin."""
        bins = np.arange(len(self.low))
        first, last = self.intervals[:, :1], self.intervals[:, 1:]
        return ((bins >= first) & (bins <= last)).astype(np.float64)

    def condition(self, interval: int) -> Condition:
        """Return the condition that an interval is; a speed from zero on is one on velocity."""
        coordinate, (first, last) = self.coordinate, self.intervals[interval]
        low, high = float(self.low[first]), float(self.high[last])
        lowest, highest = float(self.low[0]), float(self.high[-1])
        if coordinate.name == "speed" and low <= lowest:
            coordinate, low = COORDINATES["velocity"], -high
        words = coordinate.words(low, high, lowest, highest)
        return Condition(coordinate.name, low, high, words)


class Strongest(NamedTuple):
    """The strongest region of a scan: its divergence, and a condition on each coordinate."""

    strength: float
    conditions: tuple[Condition, ...]


@dataclass(frozen=True)
class Scan:
    """All intervals of a coordinate, or all rectangles of two."""

    axes: tuple[Axis, ...]

    @classmethod
    def of(cls, series: ResidualSeries, joint: int, names: Sequence[str]) -> "Scan | None":
        """Return the scan; None if a coordinate does not vary."""
        count = ALONE if len(names) == 1 else TOGETHER
        axes = [Axis.of(series, joint, name, count) for name in names]
        found = tuple(axis for axis in axes if axis is not None)
        return cls(found) if len(found) == len(names) else None

    def strength(self, error: Floats) -> Floats:
        """Return (S, I1, I2) the divergence of each region for (S, M) squared errors.

        It is 0 where a region holds less error than time, or too little or too much time.
        """
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

    def best(self, error: Floats) -> Strongest:
        """Return the strongest region for (M,) squared errors."""
        strength = self.strength(error[None])[0]
        place = np.unravel_index(int(np.argmax(strength)), strength.shape)
        conditions = (axis.condition(int(k)) for axis, k in zip(self.axes, place, strict=False))
        return Strongest(float(strength[place]), tuple(conditions))


def divergence(share: Floats, time: Floats) -> Floats:
    """Return the divergence of Bernoulli(share) from Bernoulli(time)."""
    usable = (time >= LEAST_TIME) & (time <= MOST_TIME)
    found = np.zeros(np.broadcast_shapes(np.shape(share), np.shape(time)))
    t, e = time[usable], np.clip(share[..., usable], 1e-12, 1.0 - 1e-12)
    apart = e * np.log(e / t) + (1.0 - e) * np.log((1.0 - e) / (1.0 - t))
    found[..., usable] = np.where(e > t, apart, 0.0)
    return found


def find_regions(series: ResidualSeries, joint: int, seed: int = 0) -> list[Region]:
    """Return the regions that hold most of a joint's error, the strongest first.

    The search is greedy: it takes the strongest region, sets its error to that of the rest and goes
    on. A region counts only if error that is not tied to the motion (its blocks of 1 s in random
    order) shows none as strong, over all coordinates, in 95 % of the cases, and if it holds clearly
    more error than time in the bootstrap over blocks. Time is searched apart: when a model failed
    does not answer where.

    Returns:
        Up to three, and one of time; none if the error is spread evenly or the motion is too short.
    """
    small = series.thinned(SAMPLES)
    squared, still = small.residual[:, joint] ** 2, small.still[:, joint]
    if not still.all():
        squared = np.where(still, squared[~still].mean(), squared)
    if series.too_short or not float(squared.sum()) > 0.0:
        return []
    orders = block_orders(small.motion.time, SHUFFLES, seed)

    def greedily(scans: Sequence[Scan], most: int, level: float) -> list[Region]:
        """Return up to `most` regions of these scans, each beside those before it."""
        regions: list[Region] = []
        error, covered = squared, np.zeros(len(squared), dtype=np.bool_)
        while scans and len(regions) < most and squared[covered].sum() < ENOUGH * squared.sum():
            strength, conditions = _strongest(scans, error)
            if strength <= 0.0:
                break
            region = _measured(series, joint, conditions, seed)
            if region is None:
                break
            shuffled = error[orders]
            chance = np.max([one.strength(shuffled).max(axis=(1, 2)) for one in scans], axis=0)
            if strength <= float(np.quantile(chance, 1.0 - level)):
                break
            regions.append(region)
            inside = _inside(small, joint, conditions)
            covered |= inside
            error = np.where(inside, error[~inside].mean(), error)
        return regions

    names = [[name] for name in COORDINATES if name not in APART] + [list(pair) for pair in PAIRS]
    scans = [scan for one in names if (scan := Scan.of(small, joint, one))]
    when = Scan.of(small, joint, ["time"])
    found = greedily(scans, MOST, CHANCE) + greedily([when] if when else [], 1, CHANCE_OF_TIME)
    return found + _standing_still(series, joint, seed)


def _standing_still(series: ResidualSeries, joint: int, seed: int) -> list[Region]:
    """Return the region in which a joint stands still, if it holds clearly more error than time.

    There the torque is anywhere within static friction; only what exceeds it is an error.
    """
    condition = Condition("rest", 1.0, 1.0, "standing still")
    region = _measured(series, joint, (condition,), seed)
    if region is None or not region.share_of_time >= LEAST_TIME:
        return []
    static = 0.0 if series.static is None else float(series.static[joint])
    if static <= 0.0:
        remark = "; static friction may be all of it, and this model knows none of this joint"
    elif region.rms <= STATIC * static:
        remark = (
            f"; it is within the static friction that {typeset(static, 2)} N·m of Coulomb friction "
            "allow: nothing follows from it"
        )
    else:
        remark = (
            f"; at {typeset(region.rms, 2)} N·m it exceeds what {typeset(static, 2)} N·m of "
            "Coulomb friction can hold: gravity is wrong there, or the effort"
        )
    return [replace(region, remark=remark)]


def _strongest(scans: Sequence[Scan], error: Floats) -> Strongest:
    """Return the region to name: a simple one rather than one that says little more."""
    found = [scan.best(error) for scan in scans]
    alone = [one for one in found if len(one.conditions) == 1]
    best = max(one.strength for one in alone)
    both = [one for one in found if len(one.conditions) == 2]
    pair = max(both, key=lambda one: one.strength, default=None)
    if pair is not None and pair.strength > PAIR_MUST_GAIN * best:
        return pair
    return next(one for one in alone if one.strength >= AS_GOOD * best)


def _measured(
    series: ResidualSeries, joint: int, conditions: tuple[Condition, ...], seed: int
) -> Region | None:
    """Return a region with what it holds of all samples; None if it is not worth naming."""
    inside = _inside(series, joint, conditions)
    squared = series.residual[:, joint] ** 2
    if not inside.any():
        return None
    share, time = float(squared[inside].sum() / squared.sum()), float(inside.mean())
    block = series.motion.blocks(BLOCK_SECONDS)
    weights = squared * inside, squared, inside.astype(np.float64), np.ones_like(squared)
    sums = np.stack([np.bincount(block, weight) for weight in weights], axis=1)
    drawn = resampled(sums, seed)
    shares = drawn[:, 0] / drawn[:, 1]
    with np.errstate(divide="ignore", invalid="ignore"):
        ratios = shares / (drawn[:, 2] / drawn[:, 3])
    low, high = band(shares[:, None])
    sure, _ = band(ratios[:, None])
    if share < LEAST_SHARE or share < LEAST_RATIO * time or not sure[0] >= SURE_RATIO:
        return None
    rms = float(np.sqrt(squared[inside].mean()))
    joint_name = series.motion.joints[joint]
    return Region(joint_name, conditions, share, (float(low[0]), float(high[0])), time, rms)


def _inside(series: ResidualSeries, joint: int, conditions: tuple[Condition, ...]) -> Flags:
    inside = np.logical_and.reduce([one.holds(series, joint) for one in conditions])
    resting = any(one.coordinate == "rest" for one in conditions)
    return np.asarray(inside if resting else inside & ~series.still[:, joint])
