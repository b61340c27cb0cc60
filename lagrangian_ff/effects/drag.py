"""Friction that is curved over speed: quadratic drag and a power of speed."""

import numpy as np

from lagrangian_ff.effects.base import Effect, Floats, Parameter, Shape, Values
from lagrangian_ff.effects.inputs import Inputs


class PowerLaw(Effect):
    """Loss that grows ever slower with speed: a lubricant that thins under shear."""

    name = "power_law"
    formula = "K sign(qd) |qd|^p"
    source = "the shear law of Ostwald and de Waele for lubricants that thin under shear"
    meaning = "friction that grows ever slower with speed"
    parameters = (Parameter("K", "N·m·(s/rad)^p", "friction at 1 rad/s", positive=True),)
    shapes = (
        Shape("p", "1", "power; near 0 Coulomb's, near 1 viscous", 0.2, 0.8, 0.5, bounds=True),
    )
    shows_as = "rises steeply from zero speed and ever slower then"
    look_alikes = {
        "stribeck": (
            "a power of speed rises over decades of speed and never falls; Stribeck friction "
            "falls with speed and then vanishes"
        ),
        "quadratic_drag": "over speed a power law bends towards the speed axis, drag away from it",
        "coulomb": "a power of speed goes on rising, Coulomb's step stays the same",
        "viscous": (
            "a power of speed rises steeply at first and ever slower then; the viscous line stays "
            "straight down to creeping"
        ),
    }
    motion = "speeds"
    next_motion = "drive the joint at constant speeds each twice the one before, both ways"
    caution = "with coulomb and viscous in the model, only the curvature between them is its own"

    def columns(self, x: Inputs, joint: int, shape: Values) -> Floats:
        return (x.sign(joint) * np.abs(x.qd[:, joint]) ** shape["p"])[:, None]


class QuadraticDrag(Effect):
    """Loss in proportion to the square of speed: windage, churned grease."""

    name = "quadratic_drag"
    formula = "C qd |qd|"
    source = "Newton's law of drag in turbulent flow"
    meaning = "friction that grows with the square of speed"
    parameters = (Parameter("C", "N·m·s²/rad²", "drag coefficient", positive=True),)
    shows_as = "curves upwards at high speed, the same both ways"
    look_alikes = {
        "viscous": "drag curves at high speed, the viscous line stays straight up to the highest"
    }
    motion = "speeds"
    next_motion = "drive the joint at several constant speeds up to its limit, each both ways"

    def columns(self, x: Inputs, joint: int, shape: Values) -> Floats:
        speed = x.qd[:, joint]
        return (speed * np.abs(speed))[:, None]
