"""Viscous friction."""

from collections.abc import Mapping
from typing import ClassVar

from lagrangian_ff.effects.base import Effect, Floats, Parameter
from lagrangian_ff.effects.inputs import Inputs


class Viscous(Effect):
    """Loss in proportion to speed: lubricant, back-EMF of the motor."""

    name = "viscous"
    formula = "B qd"
    source = "eq. (51), first term"
    meaning = "friction in proportion to speed"
    parameters = (Parameter("B", "N·m·s/rad", "viscous coefficient"),)
    kind = "friction"
    coordinate = "velocity"
    shows_as = "a straight line through zero speed"
    look_alikes: ClassVar[Mapping[str, str]] = {
        "coulomb": "at one speed the two are one number; two speeds tell them apart",
        "asymmetric_viscous": "the slope is the same in both directions",
        "quadratic_drag": "the line stays straight up to the highest speed",
        "power_law": "the line stays straight down to creeping",
        "load_viscous": "the slope does not change with the load",
    }
    motion = "speeds"
    next_motion = "drive the joint at several constant speeds, each both ways"
    side_by_side = True

    def columns(self, x: Inputs, joint: int, shape: Mapping[str, float]) -> Floats:
        """See `Effect.columns`."""
        return x.qd[:, [joint]]
