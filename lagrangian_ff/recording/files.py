"""Open a recording of any kind; write one as a table.

A source is a module with `recognises(path) -> bool` and `read(path, topic, progress) ->
Recording`. The first that recognises a path reads it.
"""

from collections.abc import Callable, Sequence
from os import PathLike
from pathlib import Path
from typing import Protocol

from lagrangian_ff import budget
from lagrangian_ff.errors import RecordingError
from lagrangian_ff.files import whole
from lagrangian_ff.progress import Progress, silent
from lagrangian_ff.recording.recording import Recording
from lagrangian_ff.recording.sources import bag, csv_file, npz_file


class Source(Protocol):
    """The interface of a source."""

    NAME: str

    def recognises(self, path: Path) -> bool:
        """Return whether this existing path is for this source, by its name."""

    def read(self, path: Path, topic: str | None, progress: Progress) -> Recording:
        """Return the recording of all joints.

        Raises:
            RecordingError: it is not what its name says, or nothing in it can be read.
        """


SOURCES: tuple[Source, ...] = (bag, csv_file, npz_file)


def load(
    path: str | PathLike[str],
    *,
    topic: str | None = None,
    joints: Sequence[str] | None = None,
    progress: Progress = silent,
) -> Recording:
    """Return the recording in a rosbag2 directory, a .db3, .mcap, .csv or .npz file.

    Args:
        path: a bag may be compressed or cut off; its readable part is used, and a note says so.
        topic: the JointState topic of a bag that has several.
        joints: keep these, in this order; None keeps all.

    Raises:
        RecordingError: no such file, not a recording, no samples, a joint is missing, or it costs
            more memory or disk to read than `budget` allows a file of its size.
    """
    path = Path(path)
    try:
        if not path.exists():
            raise RecordingError(f"{path}: no such file or directory")
        source = next((kind for kind in SOURCES if kind.recognises(path)), None)
        if source is None:
            kinds = "; ".join(kind.NAME for kind in SOURCES)
            raise RecordingError(f"{path}: not a recording; expected one of: {kinds}")
        if not path.is_dir():
            budget.file_size(path, RecordingError)
        recording = source.read(path, topic, progress)
    except OSError as error:
        raise RecordingError(f"{path}: cannot be read: {error.strerror or error}") from error
    except MemoryError as error:
        raise RecordingError(f"{path}: does not fit into this machine's memory") from error
    if len(recording) == 0:
        raise RecordingError(f"{recording.source}: holds no samples")
    if joints is not None:
        recording = recording.select(tuple(joints))
    progress(1.0, f"read {path.name}")
    return recording


def write_csv(path: str | PathLike[str], recording: Recording, *, overwrite: bool = False) -> Path:
    """Write `time,position/<joint>,velocity/<joint>,effort/<joint>`; NaN as empty cells.

    Temperatures follow if there are any. `Recording.start` is lost. Returns the path.

    Raises:
        RecordingError: the file exists and `overwrite` is false, or cannot be written.
    """
    return _write(csv_file.write, Path(path), recording, overwrite=overwrite)


def write_npz(path: str | PathLike[str], recording: Recording, *, overwrite: bool = False) -> Path:
    """Write the arrays `time`, `position`, `velocity`, `effort`, `joints` and `start`.

    `temperature` is there if any was recorded.

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
    try:
        with whole(path) as made:
            write(made, recording)
    except OSError as error:
        raise RecordingError(f"{path}: cannot be written: {error.strerror or error}") from error
    return path
