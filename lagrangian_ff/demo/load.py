"""How much of the machine other programs take."""

import os
from collections.abc import Callable, Iterable
from pathlib import Path

BUSY = 8  # columns of /proc/stat: user, nice, system, idle, iowait, irq, softirq, steal
IDLE = (3, 4)


class OtherWork:
    """Processors that are kept busy by others, from when this is made.

    Args:
        ours: seconds of processor that our own processes took so far.
        stat: text of /proc/stat.
    """

    def __init__(
        self,
        ours: Callable[[], float],
        stat: Callable[[], str] = lambda: Path("/proc/stat").read_text(),
    ) -> None:
        self._ours, self._stat = ours, stat
        self._before = self._look()

    def processors(self) -> float:
        """How many processors others took, 0 to all there are; 0 where the system does not tell."""
        passed, busy, ours = (
            now - before for now, before in zip(self._look(), self._before, strict=True)
        )
        count = os.cpu_count() or 1
        return max(0.0, busy - ours) / passed * count if passed > 0.0 else 0.0

    def _look(self) -> tuple[float, float, float]:
        """Processor seconds that passed, those of them that were used, and those used by us."""
        try:
            columns = [int(text) for text in self._stat().split("\n", 1)[0].split()[1 : BUSY + 1]]
        except (OSError, ValueError):
            return 0.0, 0.0, 0.0
        ticks = os.sysconf("SC_CLK_TCK")
        idle = sum(columns[k] for k in IDLE)
        return sum(columns) / ticks, (sum(columns) - idle) / ticks, self._ours()


def processor_seconds(processes: Iterable[int]) -> float:
    """Seconds of processor that this process and those of these numbers took."""
    mine = os.times()
    total = mine.user + mine.system
    for number in processes:
        try:
            # The name in parentheses may hold blanks; user and system time are the 12th and 13th
            # column behind it.
            columns = Path(f"/proc/{number}/stat").read_text().rpartition(")")[2].split()
        except OSError:
            continue
        total += (int(columns[11]) + int(columns[12])) / os.sysconf("SC_CLK_TCK")
    return total
