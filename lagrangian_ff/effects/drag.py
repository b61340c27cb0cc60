"""Friction that is curved over speed: quadratic drag and a power of speed."""

from collections.abc import Mapping
from typing import ClassVar

import numpy as np

from lagrangian_ff.effects.base import Effect, Floats, Parameter, Shape
from lagrangian_ff.effects.inputs import Inputs


class QuadraticDrag(Effect):
    """Loss in proportion to the square of speed: windage, churned grease."""

    name = "quadratic_drag"
    formula = "C qd |qd|"
    source = "Newton's law of drag in turbulent flow"
    meaning = "friction that grows with the square of speed"
    parameters = (Parameter("C", "N·m·s²/rad²", "drag coefficient"),)
    kind = "friction"
    coordinate = "velocity"
    shows_as = "curves upwards at high speed, the same both ways"
    look_alikes: ClassVar[Mapping[str, str]] = {
        "viscous": "it curves at high speed",
        "asymmetric_viscous": "it is the same in both directions",
        "power_law": "it bends away from the line as speed grows, not towards it",
    }
    motion = "speeds"
    next_motion = "drive the joint at several constant speeds up to its limit, each both ways"

    def columns(self, x: Inputs, joint: int, shape: Mapping[str, float]) -> Floats:
        """See `Effect.columns`."""
        speed = x.qd[:, joint]
        return (speed * np.abs(speed))[:, None]


class PowerLaw(Effect):
    """Loss that grows ever slower with speed: a lubricant that thins under shear."""

    name = "power_law"
    formula = "K sign(qd) |qd|^p"
    source = "the shear law of Ostwald and de Waele for lubricants that thin under shear"
    meaning = "friction that grows ever slower with speed"
    parameters = (Parameter("K", "N·m·(s/rad)^p", "friction at 1 rad/s"),)
    shapes = (Shape("p", "1", "power of speed; near 0 Coulomb's, near 1 viscous", 0.2, 0.8, 0.5),)
    kind = "friction"
    coordinate = "velocity"
    shows_as = "rises steeply from zero speed and ever slower then"
    look_alikes: ClassVar[Mapping[str, str]] = {
        "coulomb": "it goes on rising with speed",
        "viscous": "it rises steeply at first and ever slower then",
        "stribeck": "it rises with speed over several decades, and never falls",
        "quadratic_drag": "it bends towards the speed axis, not away from it",
    }
    motion = "speeds"
    next_motion = "drive the joint at constant speeds each twice the one before, both ways"
    caution = "with coulomb and viscous in the model, only the curvature between them is its own"

    def columns(self, x: Inputs, joint: int, shape: Mapping[str, float]) -> Floats:
        """See `Effect.columns`."""
        return (x.sign(joint) * np.abs(x.qd[:, joint]) ** shape["p"])[:, None]
