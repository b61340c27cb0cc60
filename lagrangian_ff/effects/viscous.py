"""Viscous friction."""

from lagrangian_ff.effects.base import Effect, Floats, Parameter, Values
from lagrangian_ff.effects.inputs import Inputs


class Viscous(Effect):
    """Loss in proportion to speed: lubricant, back-EMF of the motor."""

    name = "viscous"
    formula = "B qd"
    source = "eq. (51), first term"
    meaning = "friction in proportion to speed"
    parameters = (Parameter("B", "N·m·s/rad", "viscous coefficient", positive=True),)
    shows_as = "a straight line through zero speed"
    motion = "speeds"
    next_motion = "drive the joint at several constant speeds, each both ways"
    plain = True
    side_by_side = True

    def columns(self, x: Inputs, joint: int, shape: Values) -> Floats:
        return x.qd[:, [joint]]
