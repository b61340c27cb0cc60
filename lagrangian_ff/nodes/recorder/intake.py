"""From the subscription to the disk, in a thread that does nothing else."""

import threading
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from pathlib import Path

from lagrangian_ff.errors import UserError
from lagrangian_ff.nodes.common.errors import MessageError
from lagrangian_ff.nodes.common.joint_state_bytes import JointStateReader
from lagrangian_ff.recording import BagWriter

PERIOD = 0.01  # s; what a kill of the process may lose


@dataclass(frozen=True)
class Tally:
    """What a recording holds so far.

    Attributes:
        samples: joint states written.
        seconds: between the first and the last stamp.
        joints: every name that came.
    """

    samples: int = 0
    seconds: float = 0.0
    joints: tuple[str, ...] = ()

    @property
    def rate(self) -> float:
        """Samples a second; 0 where there are too few."""
        return (self.samples - 1) / self.seconds if self.seconds > 0.0 else 0.0

    def __str__(self) -> str:
        return f"{self.samples} samples, {self.seconds:.2f} s, {self.rate:.1f} Hz"


class Intake:
    """Takes serialised joint states as they come; writes them to a bag while one is open.

    Messages that are not joint states are complained about and not written; those with missing
    or NaN values are complained about and written as they came.

    Args:
        take: gives what has come since it was last called, with the ns it was received at. What
            comes while the disk stalls must wait there.
        complain: told the kind and the text of each complaint.

    Attributes:
        received: joint states so far, written or not.
    """

    def __init__(
        self,
        take: Callable[[], Iterable[tuple[bytes, int]]],
        complain: Callable[[str, str], None],
    ) -> None:
        self._take_new = take
        self._complain = complain
        self._lock = threading.Lock()
        self._reader = JointStateReader()
        self._bag: BagWriter | None = None
        self._first = self._last = 0
        self._names: dict[str, None] = {}
        self._samples = 0
        self._failure = ""
        self._warned_of_effort = False
        self.received = 0
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._run, name="intake", daemon=True)
        self._thread.start()

    def open(self, path: Path, topic: str) -> None:
        """Start a new bag; what came before is not in it.

        Raises:
            RecordingError: it cannot be written.
        """
        with self._lock:
            self._drain()
            self._bag = BagWriter(path, topic=topic)
            self._first = self._last = self._samples = 0
            self._failure = ""
            self._warned_of_effort = False

    def close_bag(self) -> None:
        """Write what has come and end the bag, where one is open.

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
        """The bag so far; after `close_bag`, the bag that was closed."""
        return Tally(self._samples, max(0, self._last - self._first) / 1e9, tuple(self._names))

    @property
    def failure(self) -> str:
        """Why writing ended early; empty where it did not."""
        return self._failure

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
            self._complain("not a joint state", f"ignored {error}")
            return
        self.received += 1
        self._names.update(dict.fromkeys(state.names))
        fault = state.fault()
        if fault:
            self._complain("unusable joint state", fault)
        elif len(state.effort) == 0 and not self._warned_of_effort:
            self._warned_of_effort = True
            self._complain(
                "no effort",
                "joint states come without effort; nothing can be identified from them",
            )
        if self._bag is None:
            return
        try:
            self._bag.append_raw(data, received)
        except UserError as error:
            self._bag, self._failure = None, str(error)
            self._complain("recording ended", f"recording ended: {error}")
            return
        self._first = self._first if self._samples else state.stamp
        self._last = max(self._last, state.stamp)
        self._samples += 1
