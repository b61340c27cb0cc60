"""The mean residual over a coordinate, with a band: what lies outside is more than chance."""

from dataclasses import dataclass

import numpy as np

from lagrangian_ff.arrays import Floats, Ints
from lagrangian_ff.diagnosis.where.coordinates import Coordinate
from lagrangian_ff.diagnosis.where.series import (
    BLOCK_SECONDS,
    FEWEST_BLOCKS,
    ResidualSeries,
    band,
    resampled,
)

BINS = 12
FEWEST_SAMPLES = 10
"""In a bin."""


@dataclass(frozen=True)
class Bins:
    """One joint's residual over one coordinate, in K bins that each hold the same share of time.

    Attributes:
        coordinate: what the bins divide.  joint: its name.
        low, high: (K,) the ends of each bin; equal for a coordinate of few values.
        mean: (K,) N·m, the mean residual.
        mean_low, mean_high: (K,) N·m, its 90 % band from a bootstrap over blocks of 1 s; the mean
            itself if the motion is too short.
        rms: (K,) N·m.
        share_of_error: (K,) of the joint's squared error.  share_of_time: (K,) of the samples.
        explained: the share of the joint's squared error that a function of this coordinate would
            take away; what the means owe to chance, by the bootstrap, is not counted.
    """

    coordinate: Coordinate
    joint: str
    low: Floats
    high: Floats
    mean: Floats
    mean_low: Floats
    mean_high: Floats
    rms: Floats
    share_of_error: Floats
    share_of_time: Floats
    explained: float

    def record(self) -> dict[str, object]:
        """Return the bins for JSON, with the axis to draw them over."""
        arrays = {name: one for name, one in vars(self).items() if isinstance(one, np.ndarray)}
        return {
            "joint": self.joint,
            "coordinate": self.coordinate.name,
            "unit": self.coordinate.unit,
            "label": self.coordinate.label,
            "explained": self.explained,
            **{name: values.tolist() for name, values in arrays.items()},
        }


def divide(coordinate: Coordinate, values: Floats, count: int) -> tuple[Ints, Floats, Floats]:
    """Return the bin of each sample, and the ends of at most `count` bins of as many samples each.

    Returns:
        (M,) the bin of each sample, -1 where the coordinate has no value; (K,) the low and (K,)
        the high end of each bin. K is 0 where the coordinate does not vary.
    """
    code = np.full(len(values), -1, dtype=np.int64)
    nothing = code, np.zeros(0), np.zeros(0)
    if coordinate.levels:
        found = np.array([level for level in coordinate.levels if np.any(values == level)])
        if len(found) < 2:
            return nothing
        for k, level in enumerate(found):
            code[values == level] = k
        return code, found, found
    known = values[np.isfinite(values)]
    count = min(count, len(known) // FEWEST_SAMPLES)
    if count < 2 or float(np.ptp(known)) <= 1e-9 * max(1.0, float(np.abs(known).max())):
        return nothing
    edges = np.unique(np.quantile(known, np.linspace(0.0, 1.0, count + 1)))
    if len(edges) < 3:
        return nothing
    inside = np.clip(np.searchsorted(edges, values, side="right") - 1, 0, len(edges) - 2)
    return np.where(np.isfinite(values), inside, -1), edges[:-1], edges[1:]


def bins_of(
    series: ResidualSeries, joint: int, coordinate: Coordinate, count: int = BINS
) -> Bins | None:
    """Return the mean of a joint's residual by bin; None if the coordinate does not vary.

    Args:
        count: how many bins; a coordinate of few values has one for each.
    """
    code, low, high = divide(coordinate, coordinate.values(series, joint), count)
    size = len(low)
    if not size:
        return None
    r = series.residual[:, joint]
    block = series.motion.blocks(BLOCK_SECONDS)
    kept = code >= 0
    place = block[kept] * size + code[kept]
    length = (int(block[-1]) + 1) * size
    weights = np.ones(len(place)), r[kept], r[kept] ** 2
    counted = [np.bincount(place, one, minlength=length).reshape(-1, size) for one in weights]
    sums = np.stack(counted, axis=1)
    count_in, total, squared = sums.sum(axis=0)
    mean, mean_square = total / count_in, squared / count_in
    means = mean[None]
    if len(sums) >= FEWEST_BLOCKS:
        drawn = resampled(sums[:, :2])
        with np.errstate(divide="ignore", invalid="ignore"):
            means = drawn[:, 1] / drawn[:, 0]
    mean_low, mean_high = band(means)
    error = float(np.sum(r**2))
    owed = np.nanvar(means, axis=0) if len(means) > 1 else mean**2
    taken = float(np.sum(count_in * (mean**2 - owed)))
    return Bins(
        coordinate,
        series.motion.joints[joint],
        low,
        high,
        mean,
        mean_low,
        mean_high,
        rms=np.sqrt(mean_square),
        share_of_error=squared / error if error > 0.0 else np.zeros(size),
        share_of_time=count_in / len(r),
        explained=min(1.0, max(0.0, taken / error)) if error > 0.0 else 0.0,
    )
