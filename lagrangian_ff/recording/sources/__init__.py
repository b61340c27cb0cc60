"""The kinds of file a recording is read from, listed once; a new format is one file here.

A source is a module with `recognises(path) -> bool` and `read(path, topic, progress) ->
Recording`. The first that recognises a path reads it.
"""

from pathlib import Path
from typing import Protocol

from lagrangian_ff.progress import Progress
from lagrangian_ff.recording.recording import Recording
from lagrangian_ff.recording.sources import bag, csv_file, npz_file


class Source(Protocol):
    """What a module must offer to take part."""

    NAME: str

    def recognises(self, path: Path) -> bool:
        """Whether this path, which exists, is for this source; decided by its name."""

    def read(self, path: Path, topic: str | None, progress: Progress) -> Recording:
        """Read all joints.

        Raises:
            RecordingError: it is not what its name says, or nothing in it can be read.
        """


SOURCES: tuple[Source, ...] = (bag, csv_file, npz_file)
