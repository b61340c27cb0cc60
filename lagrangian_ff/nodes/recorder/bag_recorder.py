"""Recording to disk, in a thread that does nothing else."""

import threading
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from pathlib import Path

from lagrangian_ff.errors import UserError
from lagrangian_ff.nodes.common.joint_state_bytes import JointStateReader, MessageError
from lagrangian_ff.recording import BagWriter

PERIOD = 0.01  # s between writings; a killed process loses no more


@dataclass(frozen=True)
class Tally:
    """The size of a recording so far.

    Attributes:
        samples: joint states written.
        seconds: between the first and the last stamp.
        joints: all names seen.
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
        self._samples = 0
        self.failure = ""
        self._warned_of_effort = False
        self.received = 0
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._run, name="bag recorder", daemon=True)
        self._thread.start()

    def open(self, path: Path, topic: str) -> None:
        """Start a new bag, without the messages that came before.

        Raises:
            RecordingError: it cannot be written.
        """
        with self._lock:
            self._drain()
            self._bag = BagWriter(path, topic=topic)
            self._first = self._last = self._samples = 0
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
    def tally(self) -> Tally:
        """Return the size of the bag; after `close_bag`, that of the closed one."""
        return Tally(self._samples, max(0, self._last - self._first) / 1e9, tuple(self._names))

    def stop(self) -> None:
        """End the bag and the thread."""
        self._stop.set()
        self._thread.join(timeout=2.0)
        self.close_bag()

    def _run(self) -> None:
        while not self._stop.wait(PERIOD):
            with self._lock:
                self._drain()

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
        self._names.update(dict.fromkeys(state.names))
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
            self._bag, self.failure = None, str(error)
            self._warn("recording ended", f"recording ended: {error}")
            return
        self._first = self._first if self._samples else state.stamp
        self._last = max(self._last, state.stamp)
        self._samples += 1
