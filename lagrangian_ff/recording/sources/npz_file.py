"""NumPy archives: `time`, `position`, `velocity` (optional), `effort`, `joints`.

`temperature`, °C, may be there, of the shape of the position.

The names used by other collections (`times`, `positions`, `velocities`, `torques`) are read as
well; joints without names are called joint_1, joint_2, ...
"""

import tokenize
import zipfile
import zlib
from pathlib import Path
from typing import Any

import numpy as np

from lagrangian_ff.arrays import Floats
from lagrangian_ff.errors import RecordingError
from lagrangian_ff.progress import Progress
from lagrangian_ff.recording.recording import TEMPERATURE, Recording, from_arrays

NAME = "an .npz with time, position, velocity, effort, joints"
_KEYS = {
    "time": ("time", "times"),
    "position": ("position", "positions"),
    "velocity": ("velocity", "velocities"),
    "effort": ("effort", "efforts", "torques"),
    TEMPERATURE: ("temperature", "temperatures"),
}
_UNPACKING = (EOFError, RuntimeError, zipfile.BadZipFile, zlib.error)
_PARSING = (ValueError, TypeError, KeyError, MemoryError, SyntaxError, tokenize.TokenError)
DAMAGED = (*_UNPACKING, *_PARSING)
"""Errors of a damaged archive: a flipped bit can reach the zip's flags (RuntimeError) and the text
of an array's shape, which cannot be parsed (SyntaxError, TokenError) or is huge (MemoryError)."""


def recognises(path: Path) -> bool:
    """Return whether its name ends in .npz."""
    return path.suffix.lower() == ".npz"


def read(path: Path, topic: str | None, progress: Progress) -> Recording:
    """Return the arrays as a recording; `topic` is not used."""
    try:
        with np.load(path, allow_pickle=False) as archive:
            if not isinstance(archive, np.lib.npyio.NpzFile):
                raise RecordingError(f"{path}: a single array, expected an .npz archive")
            found = {
                name: np.asarray(archive[key], dtype=np.float64)
                for name, keys in _KEYS.items()
                if (key := next((key for key in keys if key in archive), None)) is not None
            }
            names = [str(name) for name in archive["joints"]] if "joints" in archive else None
            start = float(archive["start"]) if "start" in archive else 0.0
            keys = list(archive)
    except DAMAGED as error:
        raise RecordingError(f"{path}: not a readable .npz archive: {error}") from error
    for required in ("time", "position"):
        if required not in found:
            raise RecordingError(
                f"{path}: no array `{required}`; expected time, position, velocity, effort and "
                f"joints, found {', '.join(keys) or 'nothing'}"
            )
    position = found["position"]
    if position.ndim != 2 or found["time"].ndim != 1:
        raise RecordingError(
            f"{path}: time has shape {found['time'].shape} and position {position.shape}; "
            "expected (samples,) and (samples, joints)"
        )
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
