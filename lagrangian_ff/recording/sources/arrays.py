"""What sources that hold plain arrays share."""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from lagrangian_ff.errors import RecordingError
from lagrangian_ff.recording.recording import Recording

Floats = NDArray[np.float64]
_EPOCH = 1e8  # times above are dates (1973 and later), not seconds since start-up


def from_arrays(
    path: Path,
    *,
    joints: list[str],
    time: Floats,
    position: Floats,
    velocity: Floats,
    effort: Floats,
    start: float = 0.0,
) -> Recording:
    """A recording of arrays (M,) and (M, N); times that are dates are made relative.

    Raises:
        RecordingError: a time is not a number, or shapes disagree.
    """
    bad = ~np.isfinite(time)
    if bad.any():
        raise RecordingError(
            f"{path}: time is not a number in {int(bad.sum())} samples, first in sample "
            f"{int(np.argmax(bad)) + 1} of {len(time)}"
        )
    if start == 0.0 and len(time) and time[0] > _EPOCH:
        start = float(time[0])
        time = time - start
    return Recording(
        joints=tuple(joints),
        time=np.ascontiguousarray(time),
        position=position,
        velocity=velocity,
        effort=effort,
        start=start,
        source=str(path),
    )
