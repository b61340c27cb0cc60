"""Recording to disk, in a thread that does nothing else."""

import shutil
import threading
import time
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from pathlib import Path

from lagrangian_ff.errors import UserError
from lagrangian_ff.nodes.common.joint_state_bytes import JointStateReader, MessageError
from lagrangian_ff.recording import BagWriter

PERIOD = 0.01  # s between writings; a killed process loses no more
LOOKS = 1.0  # s between looks at the free space
RECORD = 31  # bytes that MCAP adds to a message


def free_space(directory: Path) -> int:
    """Return the free bytes where this directory is or will be made."""
    there = next(one for one in (directory, *directory.parents) if one.exists())
    return shutil.disk_usage(there).free


def lasting(free: int, reserve: int, rate: float) -> str:
    """Return how long a recording may last, in words.

    Args:
        free: bytes on the disk.
        reserve: of them those that a recording leaves.
        rate: bytes a second; 0 = not known yet.
    """
    left = max(0, free - reserve)
    said = f"the disk has {left / 1e9:.1f} GB for recordings ({reserve / 1e9:g} GB stay free)"
    if rate <= 0.0:
        return said
    minutes = left / rate / 60.0
    lasts = f"{minutes:.0f} min" if minutes < 120.0 else f"{minutes / 60.0:.0f} h"
    return f"{said}: {lasts} at {rate / 1e6:.2g} MB/s"


@dataclass(frozen=True)
class Tally:
    """The size of a recording so far.

    Attributes:
        samples: joint states written.
        seconds: between the first and the last stamp; messages without have the time received.
        joints: the names in it.
    """

    samples: int = 0
    seconds: float = 0.0
    joints: tuple[str, ...] = ()

    def __str__(self) -> str:
        rate = (self.samples - 1) / self.seconds if self.seconds > 0.0 else 0.0
        return f"{self.samples} samples, {self.seconds:.2f} s, {rate:.1f} Hz"


class BagRecorder:
    """Takes serialised joint states and writes them to a bag while one is open.

    Messages that are not joint states cause a warning and are not written; those with missing
    or NaN values cause a warning and are written as they are.

    Args:
        take: yields the messages since its last call, each with its time of reception in ns.
            Messages must wait there while the disk stalls.
        warn: receives the kind and the text of each warning.

    Attributes:
        received: joint states so far, written or not.
        rate: bytes a second that they take in a bag, over the last second.
        failure: why writing ended early; empty if it did not.
    """

    def __init__(
        self, take: Callable[[], Iterable[tuple[bytes, int]]], warn: Callable[[str, str], None]
    ) -> None:
        self._take_new = take
        self._warn = warn
        self._lock = threading.Lock()
        self._reader = JointStateReader()
        self._bag: BagWriter | None = None
        self._first = self._last = 0
        self._names: dict[str, None] = {}
        self._seen: dict[str, None] = {}
        self._samples = 0
        self.failure = ""
        self._warned_of_effort = False
        self.received = self._volume = 0
        self.rate = 0.0
        self._reserve = 0
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._run, name="bag recorder", daemon=True)
        self._thread.start()

    def open(self, path: Path, topic: str, reserve: int = 0) -> None:
        """Start a new bag, without the messages that came before.

        Args:
            reserve: bytes of the disk to leave free; the bag ends before.

        Raises:
            RecordingError: it cannot be written.
        """
        with self._lock:
            self._drain()
            self._bag, self._reserve = BagWriter(path, topic=topic), reserve
            self._first = self._last = self._samples = 0
            self._names.clear()
            self.failure = ""
            self._warned_of_effort = False

    def close_bag(self) -> None:
        """Write the waiting messages and end the bag, if one is open.

        Raises:
            RecordingError: it cannot be written.
        """
        with self._lock:
            self._drain()
            bag, self._bag = self._bag, None
            if bag is not None:
                bag.close()

    @property
    def joints(self) -> tuple[str, ...]:
        """Return the names of all joints that were heard of, recorded or not."""
        return tuple(self._seen)

    @property
    def tally(self) -> Tally:
        """Return the size of the bag; after `close_bag`, that of the closed one."""
        return Tally(self._samples, max(0, self._last - self._first) / 1e9, tuple(self._names))

    def stop(self) -> None:
        """End the bag and the thread."""
        self._stop.set()
        self._thread.join(timeout=2.0)
        self.close_bag()

    def _run(self) -> None:
        looked, volume = time.monotonic(), 0
        while not self._stop.wait(PERIOD):
            with self._lock:
                self._drain()
                if (passed := time.monotonic() - looked) > LOOKS:
                    self.rate = (self._volume - volume) / passed
                    looked, volume = looked + passed, self._volume
                    self._look_at_space()

    def _look_at_space(self) -> None:
        """End the bag while there is space to end it properly."""
        bag = self._bag
        try:
            if bag is None or free_space(bag.path) >= self._reserve:
                return
        except OSError:
            return  # writing will say what is wrong
        failure = (
            f"less than {self._reserve / 1e9:g} GB are free beside {bag.path}: delete recordings "
            "or set output_directory"
        )
        try:
            bag.close()
        except UserError as error:
            failure = f"{failure}; {error}"
        self._end(failure)

    def _end(self, failure: str) -> None:
        self._bag = None
        self._warn("recording ended", f"recording ended: {failure}")
        self.failure = failure  # last: who sees it finds the bag ended and the warning given

    def _drain(self) -> None:
        for data, received in self._take_new():
            self._take(data, received)

    def _take(self, data: bytes, received: int) -> None:
        try:
            state = self._reader.read(data)
        except MessageError as error:
            self._warn("not a joint state", f"ignored {error}")
            return
        self.received += 1
        self._volume += len(data) + RECORD
        self._seen.update(dict.fromkeys(state.names))
        fault = state.fault()
        if fault:
            self._warn("unusable joint state", fault)
        elif len(state.effort) == 0 and not self._warned_of_effort:
            self._warned_of_effort = True
            self._warn(
                "no effort", "joint states come without effort; nothing can be identified from them"
            )
        if self._bag is None:
            return
        try:
            self._bag.append(data, received)
        except UserError as error:
            self._end(str(error))
            return
        self._names.update(dict.fromkeys(state.names))
        at = state.stamp or received
        self._first = self._first if self._samples else at
        self._last = max(self._last, at)
        self._samples += 1
