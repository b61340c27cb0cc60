"""The threshold that chance passes once in hours, from the largest output of each second."""

from collections import deque

import numpy as np

from lagrangian_ff.arrays import Flags, Floats

BLOCK = 1.0
"""s, of which the largest output counts."""
HOUR = 3600.0
"""s of which the largest outputs are kept."""
RARE = 3.0 * HOUR
"""s in which chance may raise one alarm. One an hour is allowed; a tail known from minutes errs."""
LEARNING = 120
"""Blocks before the first alarm: live, a model errs more than on what it learned."""
ENOUGH = 300
"""Blocks beside which those that were known before no longer count."""
TAIL = 0.25
"""Share of the blocks, from the largest output on, that shows how fast the tail falls."""
HEAVIER = 0.1
"""Added to the shape of the tail: two of its deviations, as few blocks as there are at first."""
AFTERMATH = 3
"""Blocks after one with an alarm that may still be of what raised it."""
APART = 30
"""While alarms last, one block in so many is learned from, cut to the largest learned before. A
touch then hardly raises the threshold; an arm that has changed for good raises it slowly."""
LIGHTEST, HEAVIEST = 1e-6, 0.5
"""Shapes of a tail: from that of an exponential to one whose variance is infinite."""


class Chance:
    """The largest output of each second, and the threshold that follows from them.

    Args:
        joints: N.
        share: of the alarms by chance that this threshold may raise.
        known: (B, N) largest outputs of some seconds, as far as they are known before.

    Attributes:
        learned: number of live blocks.
        threshold: (N,) infinite before `LEARNING` of them.
    """

    def __init__(self, joints: int, share: float, known: Floats | None = None) -> None:
        self._share = share
        self._known = np.zeros((0, joints)) if known is None else known
        self._blocks: deque[Floats] = deque(maxlen=round(HOUR / BLOCK))
        self._number, self._largest, self._count, self._most = -1, np.zeros(joints), 0, 0
        self._since, self._quiet = APART, AFTERMATH + 1
        self.threshold = np.full(joints, np.inf)

    @property
    def learned(self) -> int:
        return len(self._blocks)

    def take(self, at: int, z: Floats, counts: Flags, alarm: bool) -> None:
        """Take an output.

        A block that was judged for less than half of its time does not count.

        Args:
            at: ns.  z: (N,) over what is expected.  counts: (N,) whether it counts.
            alarm: whether there is an alarm.
        """
        number = at // round(BLOCK * 1e9)
        if number != self._number:
            self._most = max(self._most, self._count)
            if 2 * self._count > self._most:
                self._learn(self._largest)
            self._number, self._largest, self._count = number, np.zeros_like(z), 0
            self._quiet += 1
        self._largest = np.maximum(self._largest, np.where(counts, z, 0.0))
        self._count += int(counts.any())
        if alarm:
            self._quiet = 0

    def _learn(self, block: Floats) -> None:
        self._since += 1
        if self._quiet <= AFTERMATH and len(self._blocks) >= LEARNING:
            if self._since < APART:
                return
            self._since = 0
            block = np.minimum(block, np.max(self._blocks, axis=0))
        self._blocks.append(block)
        if len(self._blocks) >= LEARNING:
            seen = np.array(self._blocks)
            # With enough of them, the live ones alone say what is usual.
            if len(seen) < ENOUGH:
                seen = np.concatenate([self._known, seen])
            self.threshold = once_in(RARE * len(block) / self._share, seen)


def starts_of_blocks(time: Floats) -> np.ndarray[tuple[int], np.dtype[np.intp]]:
    """Return the first row of each block of times (M,) s."""
    number = np.floor(time / BLOCK).astype(np.int64)
    return np.flatnonzero(np.diff(number, prepend=number[0] - 1))


def once_in(seconds: float, blocks: Floats) -> Floats:
    """Return (N,) the output that chance reaches once in some time.

    What the largest blocks exceed a high level by has a generalised Pareto distribution (Pickands
    1975, Annals of Statistics 3), fitted by probability-weighted moments (Hosking and Wallis 1987,
    Technometrics 29). Joints share its shape: one alone has too few blocks to show it.

    Args:
        seconds: s.  blocks: (B, N) the largest output of each block, B > 4.
    """
    ordered = np.sort(blocks, axis=0)[::-1]
    many = max(2, round(TAIL * len(ordered)))
    level, beyond = ordered[many], (ordered[:many] - ordered[many])[::-1]
    rank = (np.arange(1, many + 1) - 0.35) / many
    mean = np.maximum(beyond.mean(axis=0), 1e-9)
    weighted = np.maximum(((1.0 - rank)[:, None] * beyond).mean(axis=0), 1e-10)
    shape = float(np.mean(2.0 - mean / np.maximum(mean - 2.0 * weighted, 1e-3 * mean)))
    shape = float(np.clip(shape + HEAVIER, LIGHTEST, HEAVIEST))
    share = max(seconds / BLOCK * many / len(ordered), 1.0)
    return np.asarray(level + mean * (1.0 - shape) / shape * (share**shape - 1.0))
