"""Coulomb friction."""

from collections.abc import Mapping

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

    def columns(self, x: Inputs, joint: int, shape: Mapping[str, float]) -> Floats:
        """See `Effect.columns`."""
        return np.tanh(x.qd[:, [joint]] / shape["v0"])
