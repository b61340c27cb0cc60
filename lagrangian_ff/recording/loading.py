"""Open a recording of any kind."""

from collections.abc import Sequence
from os import PathLike
from pathlib import Path

from lagrangian_ff.errors import RecordingError
from lagrangian_ff.progress import Progress, silent
from lagrangian_ff.recording.recording import Recording
from lagrangian_ff.recording.sources import SOURCES


def load(
    path: str | PathLike[str],
    *,
    topic: str | None = None,
    joints: Sequence[str] | None = None,
    progress: Progress = silent,
) -> Recording:
    """Read a rosbag2 directory, a bare .db3 or .mcap, a CSV or an .npz file.

    Args:
        path: a bag may be compressed and may have been cut off; what is readable is used and
            a note says so.
        topic: which JointState topic of a bag, where it holds several.
        joints: keep these, in this order; None keeps all.

    Raises:
        RecordingError: no such file, not a recording, no samples, or a joint is missing.
    """
    path = Path(path)
    if not path.exists():
        raise RecordingError(f"{path}: no such file or directory")
    source = next((kind for kind in SOURCES if kind.recognises(path)), None)
    if source is None:
        kinds = "; ".join(kind.NAME for kind in SOURCES)
        raise RecordingError(f"{path}: not a recording; expected one of: {kinds}")
    try:
        recording = source.read(path, topic, progress)
    except OSError as error:
        raise RecordingError(f"{path}: cannot be read: {error.strerror or error}") from error
    if len(recording) == 0:
        raise RecordingError(f"{recording.source}: holds no samples")
    if joints is not None:
        recording = recording.select(tuple(joints))
    progress(1.0, f"read {path.name}")
    return recording
