"""A constant torque."""

import numpy as np

from lagrangian_ff.effects.base import Effect, Floats, Parameter, Values
from lagrangian_ff.effects.inputs import Inputs


class Offset(Effect):
    """A torque that is always there: a current sensor's zero, or uneven Coulomb friction."""

    name = "offset"
    formula = "c"
    source = "eq. (51), third term"
    meaning = "constant torque, as from a current sensor's zero"
    parameters = (Parameter("c", "N·m", "constant torque"),)
    kind = "measurement"
    part = "gravity"
    coordinate = "direction"
    shows_as = "the same error in both directions, everywhere"
    motion = "slow sweep"
    next_motion = "sweep slowly through the whole range, forth and back; read the effort at rest"
    constant = True
    caution = "asymmetric_coulomb is Coulomb friction plus this"
    side_by_side = True

    def columns(self, x: Inputs, joint: int, shape: Values) -> Floats:
        return np.ones((len(x), 1))
