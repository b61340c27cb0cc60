"""Time: work at a fixed rate, which rclpy timers miss, and the clocks that a node goes by."""

import threading
import time
from collections.abc import Callable
from contextlib import suppress
from typing import TYPE_CHECKING, Protocol

if TYPE_CHECKING:
    from rclpy.node import Node


STOPPED = 0.01  # s between checks whether instants go on
BACK = 1_000_000_000  # ns; a clock that goes back by more was set back


class Pacing(Protocol):
    """A source of the instants to work at."""

    def wait(self) -> range:
        """Wait briefly and return the indices of the instants that are due, perhaps none."""


class Pacer:
    """The instants start + k·period on a monotonic clock, and a count of those missed.

    Args:
        period: s between two instants.
        most: largest number of past instants returned at once.
        skip: whether older ones are left out, for work of which only the newest counts; if not,
            they come next, for work that must not have holes.
        clock: ns of a monotonic clock.
        sleep: s to wait.

    Attributes:
        speed: factor of real time; 0 stops the instants. May be set at any time.
        start: ns of instant 0, or of the last change of speed.
        late: instants returned at least one period after their time.
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
        self.late = self.skipped = 0
        self._most, self._skip = most, skip
        self._clock, self._sleep = clock, sleep
        self._next = 1

    def instant(self, index: int) -> int:
        """Return the time of this instant on the monotonic clock, ns."""
        return self.start + index * self.period

    @property
    def behind(self) -> float:
        """Return the s since the oldest instant still waiting; 0 if none waits."""
        if self._speed == 0.0:
            return 0.0
        return max(0, self._clock() - self.instant(self._next)) / 1e9

    def wait(self) -> range:
        """Sleep until the next instant and return the indices that are due; none while stopped."""
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
    """The instants k·period of another clock, such as that of a simulation.

    Only the newest instant counts. A clock that is set back continues from there.

    Args:
        period: s between two instants.
        clock: the other clock, ns.
        rest: waits for the clock to move, for some ms at most.
    """

    def __init__(self, period: float, clock: Callable[[], int], rest: Callable[[], object]) -> None:
        self._period = round(period * 1e9)
        self._set_back = BACK // self._period
        self._clock = clock
        self._rest = rest
        self._last = clock() // self._period

    def wait(self) -> range:
        """Rest once and return the index of a new instant; none while the clock stands."""
        self._rest()
        index = self._clock() // self._period
        if self._last - self._set_back <= index <= self._last:
            return range(0)
        self._last = index
        return range(index, index + 1)


class RateMeter:
    """The rate of events since it was last taken."""

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self._clock = clock
        self._since = clock()
        self._count = 0

    def add(self, count: int = 1) -> None:
        """Count events."""
        self._count += count

    def take(self) -> float:
        """Return the events per second since the last call, and start from zero."""
        now = self._clock()
        rate = self._count / max(now - self._since, 1e-9)
        self._since, self._count = now, 0
        return rate


class PacedThread:
    """A thread that calls `work` with the instants that are due, until it is stopped.

    An exception in `work` goes to `failed`, and the next instant follows all the same: a thread
    that ends silently would leave its last output standing.
    """

    def __init__(
        self,
        pacer: Pacing,
        work: Callable[[range], None],
        failed: Callable[[Exception], None],
        name: str,
    ) -> None:
        self._pacer, self._work, self._failed = pacer, work, failed
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._run, name=name, daemon=True)
        self._thread.start()

    def _run(self) -> None:
        while not self._stop.is_set():
            try:
                if due := self._pacer.wait():
                    self._work(due)
            except Exception as error:
                with suppress(Exception):  # an end of the thread would be worse
                    self._failed(error)

    def stop(self) -> None:
        """End after the present instant; return when the thread has ended."""
        self._stop.set()
        self._thread.join(timeout=2.0)


class NodeTime:
    """The node's clock, and the steady seconds its watchdogs count in.

    With use_sim_time both are the simulation's: a robot whose machine is slow is not silent. The
    stamps of joint states then count as time, too, since /clock may come less often than they do.

    Attributes:
        simulated: whether use_sim_time was set when this was made.
    """

    def __init__(self, node: "Node") -> None:
        self._clock = node.get_clock()
        self.simulated = bool(node.get_parameter("use_sim_time").value)
        self._stamped = 0

    def stamped(self, at: int) -> None:
        """Take the stamp of a joint state that came now, ns."""
        self._stamped = at

    def now(self) -> int:
        """Return the time of the node's clock, ns."""
        now = int(self._clock.now().nanoseconds)
        return max(now, self._stamped) if self.simulated else now

    def steady(self) -> float:
        """Return the steady time, s since some instant."""
        return self.now() / 1e9 if self.simulated else time.monotonic()
