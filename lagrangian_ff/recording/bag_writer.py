"""Write rosbag2 directories that survive a kill of the process."""

from contextlib import AbstractContextManager
from os import PathLike
from pathlib import Path

import numpy as np

from lagrangian_ff.errors import RecordingError
from lagrangian_ff.progress import Progress, silent
from lagrangian_ff.recording.bag_storage import open_storage
from lagrangian_ff.recording.joint_state import JointStateEncoder
from lagrangian_ff.recording.recording import QUANTITIES, Recording

_BLOCK = 4096


class BagWriter(AbstractContextManager["BagWriter"]):
    """Appends serialized joint states to a new rosbag2 directory (MCAP).

    Where the library mcap is installed, each message is handed to the operating system as it is
    appended: a kill of the process loses none, a power failure may. `close` adds index and
    metadata.yaml; `load` can do without. For use by one thread.

    Args:
        path: the directory to make.
        topic: of all messages.

    Raises:
        RecordingError: the path exists or cannot be written, also from every append; no library
            that writes bags is installed.
    """

    def __init__(self, path: str | PathLike[str], *, topic: str = "joint_states") -> None:
        self.path = Path(path)
        self.count = 0
        self._latest = 0
        self._closed = False
        try:
            self._storage = open_storage(self.path, "/" + topic.removeprefix("/"))
        except FileExistsError:
            raise RecordingError(f"{self.path}: exists already; not overwritten") from None
        except OSError as error:
            raise self._unwritable(error) from error

    def append(self, data: bytes, stamp_ns: int) -> None:
        """Append a serialized JointState (CDR) received at `stamp_ns` (since the epoch)."""
        if self._closed:
            raise RecordingError(f"{self.path}: the bag is closed; nothing can be appended")
        # Readers without an index need times that never decrease; the header keeps its own.
        self._latest = max(self._latest, stamp_ns)
        try:
            self._storage.append(data, self._latest, max(0, stamp_ns), self.count)
        except OSError as error:
            raise self._unwritable(error) from error
        self.count += 1

    def close(self) -> None:
        """Write index and metadata.yaml and end appending; may be repeated."""
        if self._closed:
            return
        self._closed = True
        try:
            self._storage.close()
        except OSError as error:
            raise self._unwritable(error) from error

    def __exit__(self, *_: object) -> None:
        self.close()

    def _unwritable(self, error: OSError) -> RecordingError:
        return RecordingError(f"{self.path}: cannot be written: {error.strerror or error}")


def write_bag(
    path: str | PathLike[str],
    recording: Recording,
    *,
    topic: str = "joint_states",
    progress: Progress = silent,
) -> Path:
    """Write a recording as a rosbag2 directory (MCAP); return the path.

    Header stamps are `start` + `time`, to the nanosecond; velocity or effort that is NaN
    throughout is left empty in the messages.

    Raises:
        RecordingError: the path exists or cannot be written; a stamp is before 1970 or after 2038.
    """
    stamps = round(recording.start * 1e9) + np.round(recording.time * 1e9).astype(np.int64)
    if stamps.size and (stamps.min() < 0 or stamps.max() >= 2**31 * 10**9):
        raise RecordingError(
            f"{recording.source}: stamps from {stamps.min() / 1e9:.3f} s to "
            f"{stamps.max() / 1e9:.3f} s do not fit a ROS 2 message; shift `time` or `start`"
        )
    encoder = JointStateEncoder(
        recording.joints,
        velocity=not np.isnan(recording.velocity).all(),
        effort=not np.isnan(recording.effort).all(),
    )
    with BagWriter(path, topic=topic) as bag:
        for first in range(0, len(recording), _BLOCK):
            part = slice(first, first + _BLOCK)
            tables = (getattr(recording, name)[part] for name in QUANTITIES)
            messages = encoder.encode(stamps[part], *tables)
            for stamp, message in zip(stamps[part].tolist(), messages, strict=True):
                bag.append(message, stamp)
            progress(first / len(recording), f"write {bag.path.name}")
    progress(1.0, f"wrote {bag.path.name}")
    return bag.path
