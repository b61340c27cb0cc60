"""Compares outputs of the filters with earlier ones of the same position and speed.

An arm that repeats its work repeats its model's errors, too. The difference from earlier visits of
a state is only noise, often a tenth of the model's error.
"""

from collections import deque
from dataclasses import dataclass

import numpy as np

from lagrangian_ff.arrays import Floats
from lagrangian_ff.identification import Model
from lagrangian_ff.nodes.watching.jumps import Usual

MEMORY = 600.0
"""s of motion that are remembered."""
PACE = 0.01
"""s at least between states that are remembered or compared."""
NEAR = 0.03
"""Distance of states that count as the same: rms over joints, in parts of the usual position and
speed."""
MOST = 2000
"""Near states that are looked at; an arm that stands still has more."""
LATER = 1.0
"""s between two visits."""
VISITS = 3
"""Earlier visits at least: the median of them bears one with a touch."""
BELIEF = 4.0
"""Visits that the usual deviation counts for, beside the deviation of the visits themselves."""
PASSING = 0.0005
"""Share by which one state changes the usual deviation."""
SETTLED = 500
"""States that the usual deviation is learned from before any is judged."""
LARGEST = 9.0
"""Times the usual variance: from there on a deviation counts as no larger."""
SMALLEST = 1e-4
"""Share of the rms torque: the least deviation that is expected."""


@dataclass(frozen=True)
class _Row:
    """A state that waits until it is long enough ago."""

    at: int
    where: Floats
    output: Floats


class Familiar:
    """Compares outputs with those of earlier visits.

    Args:
        model: of N joints; its data say what a usual position and speed is.
        filters: number F of outputs of each joint.
    """

    def __init__(self, model: Model, filters: int) -> None:
        joints, usual = len(model.joints), Usual.of(model)
        self._middle = usual.middle
        self._scale = np.concatenate([usual.width, usual.speed])
        # Ones, so that the memory is taken at once and not in the course of minutes.
        self._rows = round(MEMORY / PACE)
        self._where = np.ones((self._rows, 2 * joints), dtype=np.float32)
        self._square = np.ones(self._rows, dtype=np.float32)
        self._output = np.ones((self._rows, filters, joints), dtype=np.float32)
        self._least = (SMALLEST * np.sqrt(np.mean(model.data.tau**2, axis=0))) ** 2 + 1e-18
        self._usual = np.zeros((filters, joints))
        self._compared = self._count = 0
        self._waiting: deque[_Row] = deque()
        self._last = 0

    def take(self, at: int, q: Floats, qd: Floats, output: Floats) -> Floats | None:
        """Return (F, N) how far the output is from earlier ones, over what is usual.

        Return None if there are fewer than `VISITS` earlier visits, while the usual deviation is
        not `SETTLED`, or less than `PACE` after the last state.

        Args:
            at: ns.  q, qd: (N,) rad, rad/s.  output: (F, N) N·m.
        """
        if 0 <= at - self._last < round(PACE * 0.9e9):
            return None
        self._last = at
        where = np.concatenate([q - self._middle, qd]) / self._scale
        earlier = self._visits(where)
        found = None
        if len(earlier) >= VISITS:
            middle = np.median(earlier, axis=0)
            found = self._over_usual(output - middle, earlier - middle)
            if self._compared <= SETTLED:
                found = None
        self._waiting.append(_Row(at, where, output))
        while self._waiting and not 0 <= at - self._waiting[0].at < LATER * 1e9:
            self._remember(self._waiting.popleft())
        return found

    def _visits(self, where: Floats) -> Floats:
        """Return (V, F, N) N·m, the outputs of the nearest state of each earlier visit."""
        rows = min(self._count, self._rows)
        here = where.astype(np.float32)
        squared = self._square[:rows] - 2.0 * (self._where[:rows] @ here)
        near = np.flatnonzero(squared < len(here) * NEAR**2 - float(here @ here))
        if not len(near):
            return np.zeros((0, *self._usual.shape))
        near = near[:: 1 + len(near) // MOST]
        begins = np.flatnonzero(np.diff(near, prepend=near[0]) > LATER / PACE)
        visits = np.split(near, begins)
        nearest = [visit[np.argmin(squared[visit])] for visit in visits]
        return np.asarray(self._output[nearest], dtype=np.float64)

    def _over_usual(self, deviation: Floats, others: Floats) -> Floats:
        """Return (F, N) a deviation over what is usual, and learn from it.

        Args:
            deviation: (F, N) N·m.  others: (V, F, N) N·m, of the earlier visits.
        """
        many = len(others)
        squares = np.sort(others**2, axis=0)
        # With enough visits the farthest one does not count: it may be one with a touch.
        spread = squares[: max(VISITS, many - 1)].sum(axis=0)
        if not self._compared:
            self._usual = spread / (many - 1)
        self._compared += 1
        usual = np.maximum(self._usual, self._least)
        expected = (BELIEF * usual + spread) / (BELIEF + many - 1.0) * (1.0 + 1.0 / many)
        passing = max(PASSING, 1.0 / (1.0 + self._compared))
        square = np.minimum(deviation**2 * many / (many + 1.0), LARGEST * usual)
        self._usual = usual + passing * (square - usual)
        return np.asarray(np.abs(deviation) / np.sqrt(expected))

    def _remember(self, row: _Row) -> None:
        place = self._count % self._rows
        self._where[place] = row.where
        self._square[place] = row.where @ row.where
        self._output[place] = row.output
        self._count += 1
