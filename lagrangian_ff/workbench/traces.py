"""The curves of a comparison: kept in a file of arrays, and drawn from as many points as pixels."""

from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np

from lagrangian_ff.arrays import Floats, Ints
from lagrangian_ff.diagnosis import Comparison
from lagrangian_ff.files import whole

SERIES = ("tau", "predicted", "residual", "q", "qd")
"""What can be drawn, (M, N) each: N·m, rad and rad/s."""


def write(path: Path, found: Comparison) -> float:
    """Write the curves of a comparison, and return how many seconds they last."""
    motion = found.motion
    arrays: dict[str, Any] = {"time": _running(motion.time, motion.segment)}
    arrays |= {"q": motion.q, "qd": motion.qd, "tau": motion.tau, "predicted": found.predicted}
    if found.interval is not None:
        arrays |= {"at": found.interval.at, "reach": found.interval.reach}
    with whole(path) as made, made.open("wb") as file:
        np.savez(file, allow_pickle=False, **arrays)
    return float(arrays["time"][-1])


def _running(time: Floats, segment: Ints) -> Floats:
    """Return time that goes on from one segment to the next without pause."""
    step = np.diff(time, prepend=time[:1])
    fresh = np.diff(segment, prepend=segment[:1]) != 0
    usual = float(np.median(step[~fresh][1:])) if len(time) > 2 else 0.0
    return np.cumsum(np.where(fresh, usual, step))


class Traces:
    """The curves in a file.

    Attributes:
        time: (M,) s, running through all recordings.
        series: (M, N) by name, see `SERIES`.
    """

    def __init__(self, path: Path) -> None:
        with np.load(path) as file:
            self.time: Floats = file["time"]
            self.series = {name: file[name] for name in SERIES if name in file}
        self.series["residual"] = self.series["tau"] - self.series["predicted"]

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
            values = self.series[name][:last]
            for reduce in (np.minimum.reduceat, np.maximum.reduceat):
                parts.append(reduce(values, edges, axis=0).T.astype("<f4").tobytes())
        return b"".join(parts)

    def nearest(self, at: float) -> int:
        """Return the sample nearest to a time."""
        return int(np.clip(np.searchsorted(self.time, at), 0, len(self.time) - 1))


@lru_cache(maxsize=4)
def opened(path: str, stamp: float) -> Traces:
    """Return the curves of a file as it was at this modification time."""
    return Traces(Path(path))
