"""Viscous friction."""

from collections.abc import Mapping

from lagrangian_ff.effects.base import Effect, Floats, Parameter
from lagrangian_ff.effects.inputs import Inputs


class Viscous(Effect):
    """Loss in proportion to speed: lubricant, back-EMF of the motor."""

    name = "viscous"
    formula = "B qd"
    source = "eq. (51), first term"
    meaning = "friction in proportion to speed"
    parameters = (Parameter("B", "N·m·s/rad", "viscous coefficient"),)

    def columns(self, x: Inputs, joint: int, shape: Mapping[str, float]) -> Floats:
        """See `Effect.columns`."""
        return x.qd[:, [joint]]
