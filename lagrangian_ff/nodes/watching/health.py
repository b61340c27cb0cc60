"""Whether a model is still as good as it was when it was identified."""

from collections import deque
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lagrangian_ff.nodes.common.status import Level, Status
from lagrangian_ff.nodes.streaming.ranges import Range, excess
from lagrangian_ff.nodes.watching.live import Judged

Floats = NDArray[np.float64]

FEWEST = 20
"""States of a joint below which nothing is said of it."""
FLOOR = 1e-3
"""Of the largest torque identified: no error is expected to be smaller."""
AWAY = 0.2
"""Share of the time outside the identified range from which on it is warned of."""


@dataclass(frozen=True)
class Limits:
    """When to judge, and when to warn.

    Attributes:
        window: s looked back on.
        still: rad/s; a slower joint may be held by its friction at any torque, it is not judged.
        margin: how far outside still counts as inside, as a fraction of the identified range.
        warn, error: times the error when identified.
    """

    window: float
    still: float
    margin: float
    warn: float
    error: float


class Health:
    """The residual of the last seconds against the error the model had on unseen motion.

    Args:
        joints: N names.
        expected: (N,) N·m.
        known: the identified range.
    """

    def __init__(self, joints: tuple[str, ...], expected: Floats, known: Range) -> None:
        self._joints = joints
        self._expected = np.maximum(expected, FLOOR * known.tau_max)
        self._known = known
        self._seen: deque[tuple[int, Floats, NDArray[np.bool_], bool]] = deque()

    @classmethod
    def of(cls, joints: tuple[str, ...], record: Mapping[str, Any], known: Range) -> "Health":
        """With the error that the record of a model tells."""
        errors = record.get("joints", {})
        expected = [errors.get(joint, {}).get("rmse", 0.0) for joint in joints]
        return cls(joints, np.nan_to_num(np.array(expected, dtype=np.float64)), known)

    def add(self, judged: Judged, limits: Limits) -> None:
        """Take one more instant."""
        state = judged.state
        where = tuple(values[None] for values in (state.q, state.qd, state.qdd))
        out = excess(self._joints, np.zeros(1), (where[0], where[1], where[2]),
                     self._known, limits.margin).outside[0]  # fmt: skip
        counts = (np.abs(state.qd) > limits.still) & ~out
        if self._seen and state.at < self._seen[-1][0]:
            self._seen.clear()  # the clock was set back
        self._seen.append((state.at, judged.residual**2, counts, bool(out)))
        while (state.at - self._seen[0][0]) / 1e9 > limits.window:
            self._seen.popleft()

    def forget(self) -> None:
        """Nothing has come for so long that what was seen says nothing of now."""
        self._seen.clear()

    def status(self, limits: Limits, more: Mapping[str, object]) -> Status:
        """How it stands over the last seconds."""
        if not self._seen:
            return Status(Level.STALE, "nothing to compare", more)
        squared = np.stack([each[1] for each in self._seen])
        counts = np.stack([each[2] for each in self._seen])
        away = float(np.mean([each[3] for each in self._seen]))
        number = counts.sum(axis=0)
        rms = np.sqrt((squared * counts).sum(axis=0) / np.maximum(number, 1))
        ratio = np.where(number >= FEWEST, rms / self._expected, np.nan)
        values: dict[str, object] = {}
        for n, joint in enumerate(self._joints):
            values[joint] = (
                f"{rms[n]:.4g} N·m, {ratio[n]:.2g} times what it was when identified"
                if np.isfinite(ratio[n])
                else "hardly moves: not judged"
            )
        values |= {"outside the identified range": f"{away:.0%}", **more}
        level, message = self._verdict(ratio, away, limits)
        return Status(level, message, values)

    def _verdict(self, ratio: Floats, away: float, limits: Limits) -> tuple[Level, str]:
        judged = np.flatnonzero(np.isfinite(ratio))
        bad = sorted((n for n in judged if ratio[n] > limits.warn), key=lambda n: -ratio[n])
        if bad:
            level = Level.ERROR if ratio[bad[0]] > limits.error else Level.WARN
            return level, "; ".join(
                f"residual of {self._joints[n]} is {ratio[n]:.1f} times what it was when identified"
                for n in bad
            )
        if away > AWAY:
            return Level.WARN, (
                f"{away:.0%} of the last {limits.window:g} s lie outside the range the model was "
                "identified on: not judged"
            )
        if len(judged) == 0:
            return Level.OK, "no joint moves enough to judge the model by"
        worst = judged[int(np.argmax(ratio[judged]))]
        return Level.OK, (
            f"as when identified: at most {ratio[worst]:.1f} times the error of then "
            f"({self._joints[worst]})"
        )
