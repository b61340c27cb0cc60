"""A constant torque that wanders with time."""

import numpy as np

from lagrangian_ff.effects.base import Effect, Floats, Parameter, Values
from lagrangian_ff.effects.inputs import Inputs


class Drift(Effect):
    """A current sensor's zero that wanders, in proportion to the time since the beginning."""

    name = "drift"
    formula = "c t"
    source = "first order in time of a zero that wanders"
    meaning = "constant torque that wanders with time"
    parameters = (Parameter("c", "N·m/s", "rate of the drift"),)
    kind = "measurement"
    part = "gravity"
    coordinate = "time"
    shows_as = "a straight line over time, the same both ways"
    look_alikes = {
        "offset": "a drift grows from the beginning to the end of the recording, an offset stays",
        "warm_up": "a drift is the same both ways, warming friction turns its sign with direction",
        "payload": (
            "a drift comes gradually and ignores posture; a payload comes at once and does not"
        ),
    }
    motion = "warm-up"
    next_motion = "repeat the same motion many times; read the effort with the brake on"

    def columns(self, x: Inputs, joint: int, shape: Values) -> Floats:
        """Return the column; without time there is no drift."""
        return np.where(np.isfinite(x.time), x.time, 0.0)[:, None]
