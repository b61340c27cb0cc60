"""A torque that is clipped."""

from collections.abc import Sequence

import numpy as np

from lagrangian_ff.effects.base import Effect, Floats, Parameter, Shape, Values
from lagrangian_ff.effects.inputs import Inputs

SHARES = (0.7, 0.8, 0.85, 0.9, 0.94, 0.97, 0.985)
"""Shares of the time below the limits that are tried."""


class Saturation(Effect):
    """A sensor or amplifier that gives no more than a limit, while the motion asks for more."""

    name = "saturation"
    formula = "g (clip(torque, -L, L) - torque)"
    source = "definition of a limit, taken at the torque the model predicts"
    meaning = "torque that is clipped at a limit"
    parameters = (
        Parameter("g", "1", "share of the excess that is missing; 1: all of it", positive=True),
    )
    shapes = (Shape("L", "N·m", "limit", 0.01, 1e5, 10.0),)
    kind = "measurement"
    part = "gravity"
    coordinate = "load"
    shows_as = "an error at the largest torques only, towards zero"
    motion = "exciting"
    next_motion = "repeat the motion slower or without payload, so that no torque reaches the limit"
    uses = frozenset({"torque"})

    def columns(self, x: Inputs, joint: int, shape: Values) -> Floats:
        torque = x.torque[:, [joint]]
        return np.clip(torque, -shape["L"], shape["L"]) - torque

    def candidates(self, x: Inputs, joint: int) -> Sequence[Values]:
        """Return limits that the predicted torque exceeds for a part of the time."""
        limits = np.quantile(np.abs(x.torque[:, joint]), SHARES)
        lowest = self.shapes[0].low
        return [{"L": limit} for limit in dict.fromkeys(limits.tolist()) if limit > lowest]
