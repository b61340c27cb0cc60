"""A load that is taken up on the way."""

from collections.abc import Sequence

import numpy as np

from lagrangian_ff.effects.base import Effect, Floats, Parameter, Shape, Values
from lagrangian_ff.effects.inputs import Inputs

STEP = 2.0  # s between the beginnings that are tried


class Payload(Effect):
    """A mass at the hand from some moment on, as one joint feels it.

    Joint by joint only the part can be written down that follows the joint's own angle and
    acceleration, and the torque it had before; all proximal joints show it from the same moment.
    """

    name = "payload"
    formula = "(t >= t0) (g load + J qdd + a cos(q) + b sin(q))"
    source = "Atkeson, An and Hollerbach 1986, Int. J. Robotics Research 5(3), reduced to one joint"
    meaning = "a load that is taken up at some moment"
    parameters = (
        Parameter("g", "1", "more torque of the kind that was there"),
        Parameter("J", "kg·m²", "inertia of the load about the joint", positive=True),
        Parameter("a", "N·m", "weight, amplitude of the cosine"),
        Parameter("b", "N·m", "weight, amplitude of the sine"),
    )
    shapes = (Shape("t0", "s", "when it is taken up", 0.1, 1e5, 10.0),)
    kind = "event"
    part = "gravity"
    coordinate = "time"
    shows_as = "a step over time, on all joints before the hand at once"
    look_alikes = {
        "warm_up": "a payload comes at once and is the same both ways; warming friction is neither",
        "torque_gain": "a payload begins at some moment, on several joints; a torque gain does not",
    }
    motion = "payloads"
    next_motion = "repeat the same motion with and without the payload"
    arm_event = "lasting"
    uses = frozenset({"load"})

    def columns(self, x: Inputs, joint: int, shape: Values) -> Floats:
        """Return the columns; without time the load is taken to be there."""
        q = x.q[:, joint]
        parts = np.stack([x.load[:, joint], x.qdd[:, joint], np.cos(q), np.sin(q)], axis=1)
        return parts * (x.time >= shape["t0"])[:, None]

    def candidates(self, x: Inputs, joint: int) -> Sequence[Values]:
        """Return moments every two seconds, some seconds away from beginning and end."""
        if not np.isfinite(x.time).all():
            return []
        first, last = max(self.shapes[0].low, float(x.time.min())), float(x.time.max())
        return [{"t0": t0} for t0 in np.arange(first + 2 * STEP, last - STEP, STEP).tolist()]
