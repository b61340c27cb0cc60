"""NumPy archives: `time`, `position`, `velocity` (optional), `effort`, `joints`.

`temperature`, °C, may be there, of the shape of the position.

The names used by other collections (`times`, `positions`, `velocities`, `torques`) are read as
well; joints without names are called joint_1, joint_2, ...
"""

from pathlib import Path
from typing import Any

import numpy as np

from lagrangian_ff.arrays import Floats
from lagrangian_ff.errors import RecordingError
from lagrangian_ff.progress import Progress
from lagrangian_ff.recording.archive import read_archive
from lagrangian_ff.recording.recording import TEMPERATURE, Recording, from_arrays, require_joints

NAME = "an .npz with time, position, velocity, effort, joints"
_KEYS = {
    "time": ("time", "times"),
    "position": ("position", "positions"),
    "velocity": ("velocity", "velocities"),
    "effort": ("effort", "efforts", "torques"),
    TEMPERATURE: ("temperature", "temperatures"),
}
_NAMES = ("joints", "start", *(key for keys in _KEYS.values() for key in keys))


def recognises(path: Path) -> bool:
    """Return whether its name ends in .npz."""
    return path.suffix.lower() == ".npz"


def read(path: Path, topic: str | None, progress: Progress) -> Recording:
    """Return the arrays as a recording; `topic` is not used."""
    archive = read_archive(path, _NAMES, RecordingError, NAME)
    arrays = archive.arrays
    try:
        found = {
            name: np.asarray(arrays[key], dtype=np.float64)
            for name, keys in _KEYS.items()
            if (key := next((key for key in keys if key in arrays), None)) is not None
        }
        names = [str(name) for name in arrays["joints"]] if "joints" in arrays else None
        start = float(arrays["start"]) if "start" in arrays else 0.0
    except (ValueError, TypeError) as error:
        raise RecordingError(f"{path}: not a recording: {error}") from error
    for required in ("time", "position"):
        if required not in found:
            raise RecordingError(
                f"{path}: no array `{required}`; expected time, position, velocity, effort and "
                f"joints, found {', '.join(archive.names)[:200] or 'nothing'}"
            )
    position = found["position"]
    if position.ndim != 2 or found["time"].ndim != 1:
        raise RecordingError(
            f"{path}: time has shape {found['time'].shape} and position {position.shape}; "
            "expected (samples,) and (samples, joints)"
        )
    if not np.isfinite(start):
        raise RecordingError(f"{path}: start is {start}, expected seconds since 1970, or 0")
    require_joints(str(path), position.shape[1])
    missing: Floats = np.full(position.shape, np.nan)
    joints = names or [f"joint_{number}" for number in range(1, position.shape[1] + 1)]
    tables = position, found.get("velocity", missing), found.get("effort", missing)
    return from_arrays(path, joints, found["time"], tables, start, found.get(TEMPERATURE))


def write(path: Path, recording: Recording) -> None:
    """Write the arrays under the first names above, and `start`."""
    tables: dict[str, Any] = {"time": recording.time, **recording.tables}
    joints = np.array(recording.joints, dtype=np.str_)
    # An open file keeps NumPy from appending .npz to another name.
    with path.open("wb") as file:
        np.savez(file, **tables, joints=joints, start=recording.start)
