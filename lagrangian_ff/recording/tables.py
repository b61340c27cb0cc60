"""Write recordings as plain tables."""

from collections.abc import Callable
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
    return _write(csv_file.write, Path(path), recording, overwrite=overwrite)


def write_npz(path: str | PathLike[str], recording: Recording, *, overwrite: bool = False) -> Path:
    """Write the arrays `time`, `position`, `velocity`, `effort`, `joints` and `start`.

    Returns the path.

    Raises:
        RecordingError: the file exists and `overwrite` is false, or cannot be written.
    """
    return _write(npz_file.write, Path(path), recording, overwrite=overwrite)


def _write(
    write: Callable[[Path, Recording], None], path: Path, recording: Recording, *, overwrite: bool
) -> Path:
    if path.exists() and not overwrite:
        raise RecordingError(f"{path}: exists already; not overwritten")
    # What was there stays until the new file is complete.
    part = path.with_name(path.name + ".part")
    try:
        write(part, recording)
        part.replace(path)
    except OSError as error:
        raise RecordingError(f"{path}: cannot be written: {error.strerror or error}") from error
    return path
