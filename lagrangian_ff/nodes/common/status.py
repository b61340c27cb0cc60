"""The state of a part of a node, and warnings that come once a second at most. Free of rclpy."""

import threading
import time
from collections import Counter
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from enum import IntEnum
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from lagrangian_ff.identification import Score


class Level(IntEnum):
    """The levels of diagnostic_msgs/DiagnosticStatus."""

    OK = 0
    WARN = 1
    ERROR = 2
    STALE = 3


@dataclass(frozen=True)
class Status:
    """The state of one part, in a sentence and in figures."""

    level: Level
    message: str
    values: Mapping[str, object] = field(default_factory=dict)

    def texts(self) -> dict[str, str]:
        """Return the values as text, numbers with six digits."""
        return {
            key: f"{value:.6g}" if isinstance(value, float) else str(value)
            for key, value in self.values.items()
        }


def errors_of(score: "Score", name: str = "held-out error") -> dict[str, str]:
    """Return the error by joint: RMSE in N·m, and the share of the variance missed."""
    return {
        f"{name} {joint}": f"{rmse:.4g} N·m, nMSE {nmse:.4g}"
        for joint, rmse, nmse in zip(score.joints, score.rmse, score.nmse, strict=True)
    }


class ThrottledWarnings:
    """Counts warnings by kind and logs them together, at most once per interval.

    The first warning is logged at once. Those that follow within `interval` seconds wait for the
    next `add` or `flush` after that. Any thread may add.

    Args:
        warn: logs one text.
        interval: s.
        clock: s, monotonic.

    Attributes:
        counts: number of warnings of each kind since the start, for the diagnostics.
        last: the last text of each kind.
    """

    def __init__(
        self,
        warn: Callable[[str], object],
        interval: float = 1.0,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self.counts: Counter[str] = Counter()
        self.last: dict[str, str] = {}
        self._warn, self._interval, self._clock = warn, interval, clock
        self._logged_at = -float("inf")
        self._lock = threading.Lock()
        self._pending: dict[str, tuple[int, str]] = {}

    def add(self, kind: str, text: str) -> None:
        """Count one warning of this kind; `text` says what happened and what to do."""
        with self._lock:
            self.counts[kind] += 1
            self.last[kind] = text
            self._pending[kind] = (self._pending.get(kind, (0, ""))[0] + 1, text)
        self.flush()

    def values(self) -> dict[str, object]:
        """Return count and last text of each kind, for the diagnostics."""
        with self._lock:
            return {**self.counts, **{f"last {kind}": text for kind, text in self.last.items()}}

    def flush(self) -> None:
        """Log what is pending, unless the last log is less than `interval` ago."""
        with self._lock:
            now = self._clock()
            if not self._pending or now - self._logged_at < self._interval:
                return
            pending, self._pending = self._pending, {}
            self._logged_at = now
        each = (text if n == 1 else f"{text} ({n} times)" for n, text in pending.values())
        self._warn("; ".join(each))
