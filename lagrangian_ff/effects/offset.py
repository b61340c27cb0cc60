"""A constant torque."""

from collections.abc import Mapping

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

    def columns(self, x: Inputs, joint: int, shape: Mapping[str, float]) -> Floats:
        """See `Effect.columns`."""
        return np.ones((len(x), 1))
