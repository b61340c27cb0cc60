"""A constant torque that wanders with time."""

from collections.abc import Mapping
from typing import ClassVar

import numpy as np

from lagrangian_ff.effects.base import Effect, Floats, Parameter
from lagrangian_ff.effects.inputs import Inputs


class Drift(Effect):
    """A current sensor's zero that wanders, in proportion to the time since the beginning."""

    name = "drift"
    formula = "c t"
    source = "first order in time of a zero that wanders"
    meaning = "constant torque that wanders with time"
    parameters = (Parameter("c", "N·m/s", "rate of the drift"),)
    kind = "measurement"
    coordinate = "time"
    shows_as = "a straight line over time, the same both ways"
    look_alikes: ClassVar[Mapping[str, str]] = {
        "offset": "it grows from the beginning of the recording to its end",
        "warm_up": "it is the same in both directions of motion",
        "payload": "it comes gradually, and does not change with posture",
    }
    motion = "warm-up"
    next_motion = "repeat the same motion many times; read the effort with the brake on"

    def columns(self, x: Inputs, joint: int, shape: Mapping[str, float]) -> Floats:
        """See `Effect.columns`. Without time there is no drift."""
        return np.where(np.isfinite(x.time), x.time, 0.0)[:, None]
