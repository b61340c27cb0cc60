"""Work at a fixed rate, paced by the clock instead of by rclpy timers, which miss their rate."""

import threading
import time
from collections.abc import Callable
from typing import Protocol


class Pacing(Protocol):
    """Tells when to work."""

    def wait(self) -> range:
        """Wait, not for long; the indices of the instants that are due, which may be none."""


STOPPED = 0.01  # s between looks whether instants go on
BACK = 1_000_000_000  # ns; a clock that goes back by more was set back


class Pacer:
    """The instants start + k·period on a monotonic clock, and what became of them.

    Args:
        period: s between two instants.
        most: how many instants that have passed are worked off at once.
        skip: whether older ones are left out, for work of which only the newest counts; if not,
            they are worked off next, for work that must not have holes.
        clock: ns of a monotonic clock.
        sleep: s to wait.

    Attributes:
        speed: times real time that the instants go; 0 stops them. May be set at any time.
        start: ns of instant 0, or of the last change of speed.
        late: instants worked off at least one period after their time.
        skipped: instants left out.
    """

    def __init__(
        self,
        period: float,
        most: int = 1,
        skip: bool = True,
        clock: Callable[[], int] = time.monotonic_ns,
        sleep: Callable[[float], object] = time.sleep,
    ) -> None:
        self.period = self._unhurried = round(period * 1e9)
        self.start = clock()
        self.speed = self._speed = 1.0
        self.late = 0
        self.skipped = 0
        self._most = most
        self._skip = skip
        self._clock = clock
        self._sleep = sleep
        self._next = 1

    def instant(self, index: int) -> int:
        """Ns of the monotonic clock at this instant."""
        return self.start + index * self.period

    @property
    def behind(self) -> float:
        """s since the oldest instant that waits to be worked off; 0 where none does."""
        if self._speed == 0.0:
            return 0.0
        return max(0, self._clock() - self.instant(self._next)) / 1e9

    def wait(self) -> range:
        """Sleep until the next instant; the indices of the instants that are due, none only while
        they are stopped."""
        if self.speed != self._speed:
            self._change_to(self.speed)
        if self._speed == 0.0:
            self._sleep(STOPPED)
            return range(0)
        remaining = self.instant(self._next) - self._clock()
        if remaining > 0:
            self._sleep(remaining / 1e9)
        now = max((self._clock() - self.start) // self.period, self._next)
        if self._skip:
            due = range(max(self._next, now - self._most + 1), now + 1)
        else:
            due = range(self._next, min(now, self._next + self._most - 1) + 1)
        self.skipped += due[0] - self._next
        self.late += min(now - due[0], len(due))
        self._next = due[-1] + 1
        return due

    def _change_to(self, speed: float) -> None:
        self._speed = speed
        if speed > 0.0:
            self.period = round(self._unhurried / speed)
            self.start, self._next = self._clock(), 1


class FollowingPacer:
    """The instants k·period of a clock that somebody else keeps, such as a simulation.

    The newest instant alone counts. A clock that is set back goes on from there.

    Args:
        period: s between two instants.
        clock: its ns.
        rest: waits for the clock to move, for some ms at most.
    """

    def __init__(self, period: float, clock: Callable[[], int], rest: Callable[[], object]) -> None:
        self._period = round(period * 1e9)
        self._set_back = BACK // self._period
        self._clock = clock
        self._rest = rest
        self._last = clock() // self._period

    def wait(self) -> range:
        """Rest once; the index of the instant that has come, nothing while the clock stands."""
        self._rest()
        index = self._clock() // self._period
        if self._last - self._set_back <= index <= self._last:
            return range(0)
        self._last = index
        return range(index, index + 1)


class RateMeter:
    """How many events a second came since the rate was last asked for."""

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self._clock = clock
        self._since = clock()
        self._count = 0

    def add(self, count: int = 1) -> None:
        """Count events."""
        self._count += count

    def take(self) -> float:
        """Events a second since the last call; starts counting anew."""
        now = self._clock()
        rate = self._count / max(now - self._since, 1e-9)
        self._since, self._count = now, 0
        return rate


class PacedThread:
    """A thread that calls `work` with the instants that are due, until it is stopped.

    An exception in `work` is handed to `failed` and the next instant is worked off all the
    same: a thread that ends silently would leave its last output standing.
    """

    def __init__(
        self,
        pacer: Pacing,
        work: Callable[[range], None],
        failed: Callable[[Exception], None],
        name: str,
    ) -> None:
        self._pacer = pacer
        self._work = work
        self._failed = failed
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._run, name=name, daemon=True)
        self._thread.start()

    def _run(self) -> None:
        while not self._stop.is_set():
            due = self._pacer.wait()
            try:
                if due:
                    self._work(due)
            except Exception as error:
                self._failed(error)

    def stop(self) -> None:
        """End after the instant under way; returns when it has ended."""
        self._stop.set()
        self._thread.join(timeout=2.0)
