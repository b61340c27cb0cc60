"""Signals reduced for drawing: their extremes in short bins of time, so that every peak stays."""

from typing import Any

import numpy as np

from lagrangian_ff.arrays import Floats

WIDTH = 0.02  # s
DIGITS = 5  # decimal places that are sent
LARGEST = 1000
"""Bins that wait; what is older was never drawn."""


class Bins:
    """The lowest and the highest value of signals of N joints in each bin.

    Args:
        joints: N names.
        names: of the S signals.
        start: ns that times are counted from.
    """

    def __init__(self, joints: tuple[str, ...], names: tuple[str, ...], start: int) -> None:
        self._joints, self._names, self._start = joints, names, start
        self._bin: int | None = None
        self._low = self._high = np.zeros((len(names), len(joints)))
        self._done: list[tuple[int, Floats, Floats]] = []

    def add(self, at: int, values: Floats) -> None:
        """Take values (S, N) at a time in ns; NaN is left out."""
        number = int((at - self._start) // round(WIDTH * 1e9))
        if number == self._bin:
            self._low, self._high = np.fmin(self._low, values), np.fmax(self._high, values)
            return
        if self._bin is not None:
            self._done = [*self._done[-LARGEST:], (self._bin, self._low, self._high)]
        self._bin, self._low, self._high = number, values, values

    def take(self) -> dict[str, Any] | None:
        """Return the bins that ended since the last call, for JSON; None if none did."""
        done, self._done = self._done, []
        if not done:
            return None
        low, high = (np.stack([one[k] for one in done]) for k in (1, 2))  # (bin, S, N)
        return {
            "joints": list(self._joints),
            "time": [round((number + 0.5) * WIDTH, 3) for number, _, _ in done],
            "series": {
                name: {"low": _plain(low[:, k]), "high": _plain(high[:, k])}
                for k, name in enumerate(self._names)
            },
        }


def _plain(values: Floats) -> list[list[float]]:
    return [[float(one) for one in row] for row in np.round(values, DIGITS)]
