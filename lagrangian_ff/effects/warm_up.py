"""Friction that falls while the gear warms up."""

import numpy as np

from lagrangian_ff.effects.base import Effect, Floats, Parameter, Shape, Values
from lagrangian_ff.effects.inputs import Inputs


class WarmUp(Effect):
    """Extra friction of a cold lubricant, which dies away as one thermal mass warms up."""

    name = "warm_up"
    formula = "(F_w sign(qd) + B_w qd) exp(-t / T)"
    source = (
        "Bittencourt, Wernholt, Sander-Tavallaey and Brogårdh 2010, IROS; Bittencourt and "
        "Gunnarsson 2012, ASME J. Dyn. Syst. Meas. Control 134(5)"
    )
    meaning = "friction that falls while the gear warms up"
    parameters = (
        Parameter(
            "F_w", "N·m", "dry friction of the cold gear above that of the warm", positive=True
        ),
        Parameter(
            "B_w",
            "N·m·s/rad",
            "viscous coefficient of the cold gear above that of the warm",
            positive=True,
        ),
    )
    shapes = (Shape("T", "s", "time constant of the warming", 5.0, 300.0, 60.0, bounds=True),)
    coordinate = "time"
    shows_as = "friction that dies away over the recording, while gravity stays"
    look_alikes = {
        "coulomb": "warming friction is gone when the gear is warm, Coulomb's step stays"
    }
    motion = "warm-up"
    next_motion = "repeat the same motion from cold until the error no longer changes"

    def columns(self, x: Inputs, joint: int, shape: Values) -> Floats:
        cold = np.exp(-x.time / shape["T"])
        return np.stack([cold * x.sign(joint), cold * x.qd[:, joint]], axis=1)
