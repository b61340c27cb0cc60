"""Somebody leans on the arm."""

from collections.abc import Sequence

import numpy as np

from lagrangian_ff.effects.base import Effect, Floats, Parameter, Shape, Values
from lagrangian_ff.effects.inputs import Inputs

LENGTHS = (2.0, 5.0, 10.0)  # s


class Contact(Effect):
    """A constant torque in an interval of time: what is left of a force on the arm at one joint."""

    name = "contact"
    formula = "c (t0 <= t < t0 + length)"
    source = "De Luca and Mattone 2005, ICRA, reduced to one joint and a constant"
    meaning = "something presses on the arm for a while"
    parameters = (Parameter("c", "N·m", "torque of the contact"),)
    shapes = (
        Shape("t0", "s", "when it begins", 0.1, 1e5, 10.0),
        Shape("length", "s", "how long it lasts", 0.5, 20.0, 5.0),
    )
    kind = "event"
    part = "gravity"
    coordinate = "time"
    shows_as = "a burst over time, on several joints at once"
    look_alikes = {
        "offset": "a contact lasts for a while, an offset is there all the time",
        "payload": "a contact ends and is a constant; a payload stays and grows with acceleration",
        "saturation": "a contact comes in one interval of time, saturation at every large torque",
    }
    motion = "exciting"
    next_motion = "repeat the same motion with nothing near the arm"
    arm_event = "passing"

    def columns(self, x: Inputs, joint: int, shape: Values) -> Floats:
        """Return the columns; without time there is no contact."""
        begin = shape["t0"]
        inside = (x.time >= begin) & (x.time < begin + shape["length"])
        return inside.astype(np.float64)[:, None]

    def candidates(self, x: Inputs, joint: int) -> Sequence[Values]:
        """Return intervals of several lengths, each half a length after the one before."""
        if not np.isfinite(x.time).all():
            return []
        first, last = max(self.shapes[0].low, float(x.time.min())), float(x.time.max())
        return [
            {"t0": begin, "length": length}
            for length in LENGTHS
            for begin in np.arange(first, last - length, 0.5 * length).tolist()
        ]
