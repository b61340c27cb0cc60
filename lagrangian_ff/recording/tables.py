"""Write recordings as plain tables."""

from os import PathLike
from pathlib import Path

from lagrangian_ff.errors import RecordingError
from lagrangian_ff.recording.recording import Recording
from lagrangian_ff.recording.sources import csv_file, npz_file


def write_csv(path: str | PathLike[str], recording: Recording, *, overwrite: bool = False) -> Path:
    """Write `time,position/<joint>,velocity/<joint>,effort/<joint>`; NaN as empty cells.

    `Recording.start` has no place in it and is lost. Returns the path.

    Raises:
        RecordingError: the file exists and `overwrite` is false, or cannot be written.
    """
    path = _free(path, overwrite=overwrite)
    try:
        csv_file.write(path, recording)
    except OSError as error:
        raise RecordingError(f"{path}: cannot be written: {error.strerror or error}") from error
    return path


def write_npz(path: str | PathLike[str], recording: Recording, *, overwrite: bool = False) -> Path:
    """Write the arrays `time`, `position`, `velocity`, `effort`, `joints` and `start`.

    Returns the path.

    Raises:
        RecordingError: the file exists and `overwrite` is false, or cannot be written.
    """
    path = _free(path, overwrite=overwrite)
    try:
        npz_file.write(path, recording)
    except OSError as error:
        raise RecordingError(f"{path}: cannot be written: {error.strerror or error}") from error
    return path


def _free(path: str | PathLike[str], *, overwrite: bool) -> Path:
    path = Path(path)
    if path.exists() and not overwrite:
        raise RecordingError(f"{path}: exists already; not overwritten")
    return path
