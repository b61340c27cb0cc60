"""The Stribeck effect."""

from collections.abc import Mapping
from typing import ClassVar

import numpy as np

from lagrangian_ff.effects.base import Effect, Floats, Parameter, Shape
from lagrangian_ff.effects.inputs import Inputs


class Stribeck(Effect):
    """Friction above Coulomb's at creeping speed, before the lubricant carries the contact.

    Only what exceeds Coulomb's step; with `coulomb` and `viscous` it is the whole Stribeck curve.
    """

    name = "stribeck"
    formula = "F_s sign(qd) exp(-(qd / v_s)^2)"
    source = (
        "Stribeck 1902, Z. VDI 46; the Gaussian form after Armstrong-Hélouvry, Dupont and "
        "Canudas de Wit 1994, Automatica 30(7)"
    )
    meaning = "dry friction that is higher while creeping"
    parameters = (Parameter("F_s", "N·m", "static friction above Coulomb's"),)
    shapes = (Shape("v_s", "rad/s", "Stribeck velocity", 0.01, 1.0, 0.1),)
    kind = "friction"
    coordinate = "velocity"
    shows_as = "a bump on both sides of zero speed, falling over the first tenths of rad/s"
    look_alikes: ClassVar[Mapping[str, str]] = {
        "coulomb": "it is gone at higher speed",
        "power_law": "it falls with speed and then vanishes; a power of speed goes on rising",
        "hysteresis": "it needs slow motion, not a reversal: creep without reversing",
        "delay": "it does not depend on how fast the torque changes: creep without reversing",
    }
    motion = "slow sweep"
    next_motion = "creep through the range at 0.005 to 0.2 rad/s, both ways"

    def columns(self, x: Inputs, joint: int, shape: Mapping[str, float]) -> Floats:
        """See `Effect.columns`."""
        speed = x.qd[:, joint]
        return (x.sign(joint) * np.exp(-((speed / shape["v_s"]) ** 2)))[:, None]

    def possible(self, parameters: Floats) -> bool:
        """What is lower while creeping is a step of Coulomb's that is rounded, not this."""
        return bool(parameters[0] > 0.0)
