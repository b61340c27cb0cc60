"""The curves of a comparison: kept in a file of arrays, and drawn from as many points as pixels."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np

from lagrangian_ff.arrays import Flags, Floats, Ints
from lagrangian_ff.diagnosis import Comparison
from lagrangian_ff.files import whole

SERIES = ("tau", "predicted", "residual", "lower", "upper", "q", "qd", "load")
"""What can be drawn, (M, N) each: N·m, rad and rad/s; lower and upper end the 90 % interval."""
JOIN = 0.1
"""s between stretches that are shown as one."""
MOST_SPANS = 400


def write(path: Path, found: Comparison) -> float:
    """Write the curves of a comparison, and return how many seconds they last."""
    motion = found.motion
    arrays: dict[str, Any] = {"time": running_time(motion.time, motion.segment)}
    arrays |= {"q": motion.q, "qd": motion.qd, "tau": motion.tau, "predicted": found.predicted}
    arrays["load"] = found.predicted if found.load is None else found.load
    if found.interval is not None:
        arrays |= {"at": found.interval.at, "reach": found.interval.reach}
    with whole(path) as made, made.open("wb") as file:
        np.savez(file, allow_pickle=False, **arrays)
    return float(arrays["time"][-1])


def running_time(time: Floats, segment: Ints) -> Floats:
    """Return time that goes on from one segment to the next without pause."""
    step = np.diff(time, prepend=time[:1])
    fresh = np.diff(segment, prepend=segment[:1]) != 0
    usual = float(np.median(step[~fresh][1:])) if len(time) > 2 else 0.0
    return np.asarray(np.cumsum(np.where(fresh, usual, step)))


def spans(time: Floats, inside: Flags) -> list[tuple[float, float]]:
    """Return the stretches of time in which samples are inside, short pauses closed."""
    at = np.flatnonzero(inside)
    if not len(at):
        return []
    cuts = np.flatnonzero(np.diff(time[at]) > JOIN)
    starts, ends = time[at[np.r_[0, cuts + 1]]], time[at[np.r_[cuts, len(at) - 1]]]
    longest = np.sort(np.argsort(starts - ends, kind="stable")[:MOST_SPANS])
    return [(float(starts[k]), float(ends[k])) for k in longest]


@dataclass(frozen=True)
class Axis:
    """A quantity of a map: one of "q", "qd", "tau", "load" of a joint, or "time"."""

    name: str
    joint: int = 0

    def of(self, traces: "Traces") -> Floats:
        """Return (M,) its values."""
        if self.name == "time":
            return traces.time
        return np.asarray(traces.series[self.name][:, self.joint])


class Traces:
    """The curves in a file.

    Attributes:
        time: (M,) s, running through all recordings.
        series: (M, N) by name, see `SERIES`; no interval where the comparison has none.
    """

    def __init__(self, path: Path) -> None:
        with np.load(path) as file:
            self.time: Floats = file["time"]
            self.series = {name: file[name] for name in SERIES if name in file}
            at, reach = (file.get(name) for name in ("at", "reach"))
        predicted = self.series["predicted"]
        self.series["residual"] = self.series["tau"] - predicted
        if at is not None and reach is not None and len(at):
            every = np.arange(len(self.time))
            wide = np.column_stack([np.interp(every, at, column) for column in reach.T])
            self.series["lower"], self.series["upper"] = predicted - wide, predicted + wide

    def window(self, start: float, end: float, width: int, names: tuple[str, ...]) -> bytes:
        """Return what is drawn between two times, so that every peak stays.

        Returns:
            Little-endian: three 32-bit integers, the numbers of buckets B, joints N and series S;
            B 32-bit floats, the times; then for each series and joint B least and B largest values.
        """
        first = max(0, int(np.searchsorted(self.time, start)) - 1)
        last = min(len(self.time), int(np.searchsorted(self.time, end, "right")) + 1)
        count = max(1, min(width, last - first))
        edges = first + np.floor(np.arange(count) * (last - first) / count).astype(np.int64)
        joints = self.series["tau"].shape[1]
        parts = [np.array([count, joints, len(names)], "<i4").tobytes()]
        parts.append(self.time[edges].astype("<f4").tobytes())
        for name in names:
            values = self.series.get(name, self.series["predicted"])[:last]
            for reduce in (np.minimum.reduceat, np.maximum.reduceat):
                parts.append(reduce(values, edges, axis=0).T.astype("<f4").tobytes())
        return b"".join(parts)

    def map(self, joint: int, across: Axis, up: Axis, bins: int) -> dict[str, Any]:
        """Return the rms residual of a joint over two quantities, and the samples of each bin.

        Returns:
            `x` and `y`, the ends of the map; `rms` N·m and `count`, row by row from below; None
            where there is no sample.
        """
        rest = self.series["residual"][:, joint]
        ends = [(float(v.min()), float(v.max())) for v in (across.of(self), up.of(self))]
        place = self._places(across, up, bins)
        count = np.bincount(place, minlength=bins * bins)
        total = np.bincount(place, weights=rest**2, minlength=bins * bins)
        rms = [
            float(f"{np.sqrt(t / n):.3g}") if n else None
            for t, n in zip(total.tolist(), count.tolist(), strict=True)
        ]
        return {"x": ends[0], "y": ends[1], "rms": rms, "count": count.tolist(), "bins": bins}

    def lit(
        self, across: Axis, up: Axis, bins: int, spans: Sequence[tuple[float, float]]
    ) -> list[int]:
        """Return the bins of a map in which samples of these stretches of time lie."""
        inside = np.zeros(len(self.time), dtype=bool)
        for start, end in spans:
            first, last = np.searchsorted(self.time, (start, end))
            inside[first : last + 1] = True
        return [int(k) for k in np.unique(self._places(across, up, bins)[inside])]

    def _places(self, across: Axis, up: Axis, bins: int) -> Ints:
        """Return (M,) the bin of each sample on a map, row by row from below."""
        columns, rows = (
            np.minimum((bins * (v - v.min()) / max(np.ptp(v), 1e-12)).astype(np.int64), bins - 1)
            for v in (across.of(self), up.of(self))
        )
        return np.asarray(rows * bins + columns)

    def chosen(
        self, across: Axis, up: Axis, x: tuple[float, float], y: tuple[float, float]
    ) -> list[tuple[float, float]]:
        """Return the stretches of time in which two quantities lie between these ends."""
        a, b = across.of(self), up.of(self)
        inside = (a >= x[0]) & (a <= x[1]) & (b >= y[0]) & (b <= y[1])
        return spans(self.time, np.asarray(inside))


@lru_cache(maxsize=4)
def opened(path: str, stamp: float) -> Traces:
    """Return the curves of a file as it was at this modification time."""
    return Traces(Path(path))
