"""The few regions that hold most of a joint's error, in words."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lagrangian_ff.diagnosis.where.coordinates import COORDINATES, PAIRS
from lagrangian_ff.diagnosis.where.course import Course
from lagrangian_ff.diagnosis.where.phrases import percent
from lagrangian_ff.diagnosis.where.resampling import BLOCK_SECONDS, Shuffles, band, resampled
from lagrangian_ff.diagnosis.where.scan import Found, Scan, divergence

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]

SAMPLES = 6000
"""On which regions are searched; what they hold is then counted on all."""
MOST = 3
"""Regions named per joint."""
ENOUGH = 0.8
"""Of the error: once so much lies in regions, no more are looked for."""
SHUFFLES = 100
CHANCE, CHANCE_OF_TIME = 0.05, 0.01
"""How often a region that is named may come from error that is spread evenly. Error comes and goes
by itself over more than a block, so that more is asked of a region of time."""
LEAST_RATIO, SURE_RATIO = 1.5, 1.2
"""Error over time of a region that is worth naming, and the low end of the band of that ratio."""
LEAST_SHARE = 0.1
PAIR_MUST_GAIN = 1.3
"""Two conditions are named only if they say so much more than the best single one."""
AS_GOOD = 0.9
"""A coordinate that is listed earlier is named if it is as good as the best by this factor."""


@dataclass(frozen=True)
class Condition:
    """An interval of one coordinate.

    Attributes:
        coordinate: its name.
        low, high: the ends, both included.
        words: as in "below 0.1 rad/s".
    """

    coordinate: str
    low: float
    high: float
    words: str

    def holds(self, course: Course, joint: int) -> Flags:
        """(M,) where it is met."""
        values = COORDINATES[self.coordinate].values(course, joint)
        with np.errstate(invalid="ignore"):
            return np.asarray((values >= self.low) & (values <= self.high))


@dataclass(frozen=True)
class Region:
    """A part of the motion that holds clearly more of a joint's error than of its time.

    Attributes:
        joint: its name.
        conditions: one or two, all of them met.
        share_of_error: of the joint's squared error.
        band: 90 % of it, from a bootstrap over blocks of 1 s.
        share_of_time: of the samples.
        rms: N·m, of the residual inside.
    """

    joint: str
    conditions: tuple[Condition, ...]
    share_of_error: float
    band: tuple[float, float]
    share_of_time: float
    rms: float

    @property
    def strength(self) -> float:
        """How striking it is; see `scan`."""
        share, time = np.array([self.share_of_error]), np.array([self.share_of_time])
        return float(divergence(share, time)[0])

    @property
    def place(self) -> str:
        """Where it is, without the joint."""
        return " ".join(condition.words for condition in self.conditions)

    @property
    def words(self) -> str:
        """All of it in one sentence."""
        return (
            f"{self.joint} {self.place}: {percent(self.share_of_error)} of its error in "
            f"{percent(self.share_of_time)} of the time"
        )

    def record(self) -> dict[str, object]:
        """For JSON: the first condition, and all where there are two."""
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


def find_regions(course: Course, joint: int, seed: int = 0) -> list[Region]:
    """The regions that hold most of a joint's error, the most striking first.

    Greedily: the most striking region is taken, its error set to that of the rest, and the search
    goes on. A region counts only if error that is not tied to the motion (its blocks of 1 s in
    random order) shows none so striking, whatever the coordinate, in 95 % of the cases, and if it
    holds clearly more error than time in the bootstrap over blocks. Time is looked at apart: when
    it failed does not answer where it failed.

    Returns:
        Up to three, and one of time; none where the error is spread evenly, or the
        motion is too short to tell.
    """
    small = course.thinned(SAMPLES)
    error = small.residual[:, joint] ** 2
    if course.too_short or not float(error.sum()) > 0.0:
        return []
    block = max(1, round(BLOCK_SECONDS / _step(small)))
    shuffles = Shuffles.of(len(small.motion), block, SHUFFLES, seed)
    names = [[name] for name in COORDINATES if name != "time"] + [list(pair) for pair in PAIRS]
    scans = [scan for one in names if (scan := Scan.of(small, joint, one))]
    when = Scan.of(small, joint, ["time"])
    search = _Search(course, small, joint, shuffles, seed)
    regions = search.greedily(scans, error, MOST, CHANCE)
    return regions + search.greedily([when] if when else [], error, 1, CHANCE_OF_TIME)


@dataclass(frozen=True)
class _Search:
    """What stays the same while regions of one joint are looked for."""

    course: Course
    small: Course
    joint: int
    shuffles: Shuffles
    seed: int

    def greedily(
        self, scans: Sequence[Scan], error: Floats, most: int, level: float
    ) -> list[Region]:
        """Up to `most` regions of these scans, each beside those before it."""
        regions: list[Region] = []
        covered = np.zeros(len(error), dtype=np.bool_)
        squared = error
        while scans and len(regions) < most and squared[covered].sum() < ENOUGH * squared.sum():
            scan, found = _strongest(scans, error)
            if found.strength <= 0.0:
                break
            conditions = _conditions(scan, found)
            region = _measured(self.course, self.joint, conditions, self.seed)
            if region is None:
                break
            shuffled = error[self.shuffles.order]
            chance = np.max([one.by_chance(shuffled) for one in scans], axis=0)
            if found.strength <= float(np.quantile(chance, 1.0 - level)):
                break
            regions.append(region)
            inside = _inside(self.small, self.joint, conditions)
            covered |= inside
            error = np.where(inside, error[~inside].mean(), error)
        return regions


def _strongest(scans: Sequence[Scan], error: Floats) -> tuple[Scan, Found]:
    """The region to name: a simple one rather than one that says little more."""
    found = [(scan, scan.best(error)) for scan in scans]
    alone = [one for one in found if len(one[0].axes) == 1]
    best = max(one[1].strength for one in alone)
    both = [one for one in found if len(one[0].axes) == 2]
    pair = max(both, key=lambda one: one[1].strength, default=None)
    if pair is not None and pair[1].strength > PAIR_MUST_GAIN * best:
        return pair
    return next(one for one in alone if one[1].strength >= AS_GOOD * best)


def _conditions(scan: Scan, found: Found) -> tuple[Condition, ...]:
    conditions = []
    for axis, (low, high) in zip(scan.axes, found.ends, strict=True):
        coordinate = axis.coordinate
        lowest, highest = float(axis.low[0]), float(axis.high[-1])
        if coordinate.name == "speed" and low <= lowest:
            coordinate, low = COORDINATES["velocity"], -high
        conditions.append(
            Condition(coordinate.name, low, high, coordinate.words(low, high, lowest, highest))
        )
    return tuple(conditions)


def _measured(
    course: Course, joint: int, conditions: tuple[Condition, ...], seed: int
) -> Region | None:
    """What a region holds of all samples; None where it is not worth naming."""
    inside = _inside(course, joint, conditions)
    squared = course.residual[:, joint] ** 2
    if not inside.any():
        return None
    share, time = float(squared[inside].sum() / squared.sum()), float(inside.mean())
    block = course.motion.blocks(BLOCK_SECONDS)
    sums = np.stack(
        [
            np.bincount(block, weight)
            for weight in (
                squared * inside,
                squared,
                inside.astype(np.float64),
                np.ones_like(squared),
            )
        ],
        axis=1,
    )
    drawn = resampled(sums, seed)
    shares = drawn[:, 0] / drawn[:, 1]
    with np.errstate(divide="ignore", invalid="ignore"):
        ratios = shares / (drawn[:, 2] / drawn[:, 3])
    low, high = band(shares[:, None])
    sure, _ = band(ratios[:, None])
    if share < LEAST_SHARE or share < LEAST_RATIO * time or not sure[0] >= SURE_RATIO:
        return None
    rms = float(np.sqrt(squared[inside].mean()))
    joint_name = course.motion.joints[joint]
    return Region(joint_name, conditions, share, (float(low[0]), float(high[0])), time, rms)


def _inside(course: Course, joint: int, conditions: tuple[Condition, ...]) -> Flags:
    return np.logical_and.reduce([one.holds(course, joint) for one in conditions])


def _step(course: Course) -> float:
    """s between samples."""
    steps = np.diff(course.motion.time)
    usual = steps[steps > 0.0]
    return float(np.median(usual)) if len(usual) else 1.0
