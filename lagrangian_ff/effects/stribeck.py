"""The Stribeck effect."""

from collections.abc import Sequence

import numpy as np

from lagrangian_ff.effects.base import Effect, Floats, Parameter, Shape, Values
from lagrangian_ff.effects.inputs import Inputs

CREEPING = 0.3, 0.4
"""Largest Stribeck velocity: rad/s, or share of the joint's rms speed if that is more. A bump over
most of the speeds of a motion has the form of drag, or of shear that thins, less a straight line.
"""


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
    shapes = (Shape("v_s", "rad/s", "Stribeck velocity", 0.01, 1.0, 0.1, bounds=True),)
    shows_as = "a bump on both sides of zero speed, falling over the first tenths of rad/s"
    look_alikes = {
        "coulomb": "Stribeck friction is gone at higher speed; Coulomb's never changes with it"
    }
    motion = "slow sweep"
    next_motion = "creep through the range at 0.005 to 0.2 rad/s, both ways"

    def candidates(self, x: Inputs, joint: int) -> Sequence[Values]:
        """Return the velocities at which the joint creeps, see `CREEPING`."""
        return [{"v_s": speed} for speed in creeping(self.shapes[0], x, joint)]

    def columns(self, x: Inputs, joint: int, shape: Values) -> Floats:
        speed = x.qd[:, joint]
        return (x.sign(joint) * np.exp(-((speed / shape["v_s"]) ** 2)))[:, None]


def creeping(shape: Shape, x: Inputs, joint: int) -> list[float]:
    """Return the Stribeck velocities of a shape's grid, none above those of `CREEPING`."""
    rms = float(np.sqrt(np.mean(x.qd[:, joint] ** 2))) if len(x) else 0.0
    most = max(CREEPING[0], CREEPING[1] * rms)
    return sorted({min(speed, most) for speed in shape.grid()})
