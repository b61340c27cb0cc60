"""Coulomb friction."""

from collections.abc import Mapping
from typing import ClassVar

import numpy as np

from lagrangian_ff.effects.base import Effect, Floats, Parameter, Shape
from lagrangian_ff.effects.inputs import Inputs


class Coulomb(Effect):
    """Dry friction: a constant torque against the direction of motion, smoothed at rest."""

    name = "coulomb"
    formula = "F_c tanh(qd / v0)"
    source = "eq. (51), second term, with the velocity in both tanh as the paper's text says"
    meaning = "dry friction that opposes motion whatever its speed"
    parameters = (Parameter("F_c", "N·m", "Coulomb torque"),)
    shapes = (Shape("v0", "rad/s", "speed at which friction is fully reversed", 1e-3, 0.3, 0.02),)
    kind = "friction"
    coordinate = "velocity"
    shows_as = "a step at zero speed"
    look_alikes: ClassVar[Mapping[str, str]] = {
        "viscous": "at one speed the two are one number; two speeds tell them apart",
        "asymmetric_coulomb": "the step is as high in one direction as in the other",
        "stribeck": "beyond the step nothing changes with speed, creeping included",
        "power_law": "beyond the step nothing changes with speed",
        "load_friction": "the step is as high under every load",
        "position_friction": "the step is as high at every position",
        "warm_up": "the step stays as high over time",
        "hysteresis": "the step comes at once, not over a distance after the reversal",
        "delay": "the error at reversals does not grow with the rate of the torque",
        "coupled": "the step comes where this joint reverses, whatever its neighbours do",
    }
    motion = "reversals"
    next_motion = "reverse the joint slowly, many times, at two speeds"
    side_by_side = True

    def columns(self, x: Inputs, joint: int, shape: Mapping[str, float]) -> Floats:
        """See `Effect.columns`."""
        return np.tanh(x.qd[:, [joint]] / shape["v0"])
