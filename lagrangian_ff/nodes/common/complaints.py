"""Counting what went wrong and saying so once a second at most."""

import threading
import time
from collections import Counter
from collections.abc import Callable


class Complaints:
    """Counts complaints by kind and warns about all of them together, throttled.

    The first complaint is said at once. What comes within `interval` seconds of a warning is
    gathered and said by the next complaint or `flush` after that. Any thread may complain.

    Attributes:
        counts: how often each kind came since the start, for the diagnostics.
    """

    def __init__(
        self,
        warn: Callable[[str], object],
        interval: float = 1.0,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self.counts: Counter[str] = Counter()
        self._warn = warn
        self._interval = interval
        self._clock = clock
        self._said_at = -float("inf")
        self._lock = threading.Lock()
        self._pending: dict[str, tuple[int, str]] = {}

    @property
    def total(self) -> int:
        """How many complaints of all kinds came."""
        return sum(self.counts.values())

    def add(self, kind: str, text: str) -> None:
        """Count one complaint of this kind; `text` says what came and what to do."""
        with self._lock:
            self.counts[kind] += 1
            self._pending[kind] = (self._pending.get(kind, (0, ""))[0] + 1, text)
        self.flush()

    def flush(self) -> None:
        """Say what is pending, unless the last warning is less than `interval` ago."""
        with self._lock:
            now = self._clock()
            if not self._pending or now - self._said_at < self._interval:
                return
            pending, self._pending = self._pending, {}
            self._said_at = now
        self._warn(
            "; ".join(
                text if count == 1 else f"{text} ({count} times)"
                for count, text in pending.values()
            )
        )
