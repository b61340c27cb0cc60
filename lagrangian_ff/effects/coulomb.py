"""Coulomb friction."""

import numpy as np

from lagrangian_ff.effects.base import Effect, Floats, Parameter, Shape, Values
from lagrangian_ff.effects.inputs import Inputs


class Coulomb(Effect):
    """Dry friction: a constant torque against the direction of motion, smoothed at rest."""

    name = "coulomb"
    formula = "F_c tanh(qd / v0)"
    source = "eq. (51), second term, with the velocity in both tanh as the paper's text says"
    meaning = "dry friction that opposes motion whatever its speed"
    parameters = (Parameter("F_c", "N·m", "Coulomb torque", positive=True),)
    shapes = (Shape("v0", "rad/s", "speed at which friction is fully reversed", 1e-3, 0.3, 0.02),)
    shows_as = "a step at zero speed"
    look_alikes = {"viscous": "at one speed the two are one number; two speeds tell them apart"}
    motion = "reversals"
    next_motion = "reverse the joint slowly, many times, at two speeds"
    plain = True
    sign_width = "v0"
    side_by_side = True

    def columns(self, x: Inputs, joint: int, shape: Values) -> Floats:
        return np.tanh(x.qd[:, [joint]] / shape["v0"])
