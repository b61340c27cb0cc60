"""A constant torque."""

from collections.abc import Mapping
from typing import ClassVar

import numpy as np

from lagrangian_ff.effects.base import Effect, Floats, Parameter
from lagrangian_ff.effects.inputs import Inputs


class Offset(Effect):
    """A torque that is always there: a current sensor's zero, or uneven Coulomb friction."""

    name = "offset"
    formula = "c"
    source = "eq. (51), third term"
    meaning = "constant torque, as from a current sensor's zero"
    parameters = (Parameter("c", "N·m", "constant torque"),)
    kind = "measurement"
    coordinate = "direction"
    shows_as = "the same error in both directions, everywhere"
    look_alikes: ClassVar[Mapping[str, str]] = {
        "asymmetric_coulomb": "nothing in the motion: read the effort with the brake on",
        "drift": "it stays the same from the beginning of the recording to its end",
        "spring": "it is the same at every position",
        "contact": "it is there all the time",
    }
    motion = "slow sweep"
    next_motion = "sweep slowly through the whole range, forth and back; read the effort at rest"
    caution = "asymmetric_coulomb is Coulomb friction plus this"
    side_by_side = True

    def columns(self, x: Inputs, joint: int, shape: Mapping[str, float]) -> Floats:
        """See `Effect.columns`."""
        return np.ones((len(x), 1))
