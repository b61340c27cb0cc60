"""How much of what is measured the model did not think possible."""

from collections import deque

import numpy as np
from numpy.typing import NDArray

from lagrangian_ff.identification import Model
from lagrangian_ff.identification.certainty.uncertainty import quick_factor
from lagrangian_ff.nodes.watching.health import FEWEST, Limits
from lagrangian_ff.nodes.watching.live import Judged

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]

PAUSE = 0.1
"""s between the states that are looked at: one takes 1 ms, and neighbours err alike."""


class Cover:
    """The share of the last seconds' torques that lie outside the model's 90 % intervals.

    Of ten, one should. Joints that hardly move do not count: see `Limits.still`.

    Args:
        model: of the states' joints.

    Raises:
        ModelError: the model cannot be calibrated.
    """

    def __init__(self, model: Model) -> None:
        self._joints = model.joints
        self._certain = model.quick_uncertainty
        self._seen: deque[tuple[int, Flags, Flags]] = deque()

    @classmethod
    def of(cls, model: Model) -> "Cover | None":
        """None for models of before the calibration was kept: to make it anew takes too long."""
        return None if quick_factor(model) is None else cls(model)

    def add(self, judged: Judged, limits: Limits) -> None:
        """Take one more instant, unless the last one was just now."""
        state, seen = judged.state, self._seen
        if seen and state.at < seen[-1][0]:
            seen.clear()  # the clock was set back
        if seen and (state.at - seen[-1][0]) / 1e9 < PAUSE:
            return
        outside = np.abs(judged.residual) > self._certain.reach(state.q, state.qd, state.qdd)
        seen.append((state.at, outside, np.abs(state.qd) > limits.still))
        while (state.at - seen[0][0]) / 1e9 > limits.window:
            seen.popleft()

    def forget(self) -> None:
        """Nothing has come for so long that what was seen says nothing of now."""
        self._seen.clear()

    def values(self) -> dict[str, str]:
        """For the diagnostics, by joint; of joints that moved long enough."""
        if not self._seen:
            return {}
        outside, moving = (np.stack([each[k] for each in self._seen]) for k in (1, 2))
        number = moving.sum(axis=0)
        share = (outside & moving).sum(axis=0) / np.maximum(number, 1)
        return {
            f"outside the 90 % interval {joint}": f"{share[n]:.0%}"
            for n, joint in enumerate(self._joints)
            if number[n] >= FEWEST
        }
