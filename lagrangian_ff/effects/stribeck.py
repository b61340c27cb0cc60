"""The Stribeck effect."""

import numpy as np

from lagrangian_ff.effects.base import Effect, Floats, Parameter, Shape, Values
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
    parameters = (Parameter("F_s", "N·m", "static friction above Coulomb's", positive=True),)
    shapes = (Shape("v_s", "rad/s", "Stribeck velocity", 0.01, 1.0, 0.1),)
    shows_as = "a bump on both sides of zero speed, falling over the first tenths of rad/s"
    look_alikes = {
        "coulomb": "Stribeck friction is gone at higher speed; Coulomb's never changes with it"
    }
    motion = "slow sweep"
    next_motion = "creep through the range at 0.005 to 0.2 rad/s, both ways"

    def columns(self, x: Inputs, joint: int, shape: Values) -> Floats:
        speed = x.qd[:, joint]
        return (x.sign(joint) * np.exp(-((speed / shape["v_s"]) ** 2)))[:, None]
