"""A step of friction that is smooth, and turns over at another speed one way than the other."""

import numpy as np

from lagrangian_ff.effects.base import Effect, Floats, Parameter, Shape, Values
from lagrangian_ff.effects.inputs import Inputs


class AsymmetricStep(Effect):
    """The uneven part of a smooth step whose middle is not at rest.

    Friction that rises as a sigmoid F (tanh((qd + v_c) / w) - tanh(v_c / w)) is, to first order in
    v_c / w, the even step F tanh(qd / w) of `coulomb` and this with A = -F v_c / w. A whole sigmoid
    would hold Coulomb friction again.
    """

    name = "asymmetric_step"
    formula = "A tanh(qd / w)^2"
    source = (
        "Gaz, Cognetti, Oliva, Robuffo Giordano and De Luca 2019, IEEE Robotics and Automation "
        "Letters 4(4), eq. (18): the friction of the Panda"
    )
    meaning = "a smooth step of friction that differs both ways"
    parameters = (Parameter("A", "N·m", "more friction forwards, and less backwards"),)
    shapes = (Shape("w", "rad/s", "speed over which the step rises", 0.03, 0.5, 0.15, steps=4),)
    shows_as = "a dip or bump at zero speed, the same on both sides of it"
    look_alikes = {
        "offset": "an offset stays at rest and while creeping, the uneven step is zero there",
        "asymmetric_viscous": (
            "the uneven step is flat at higher speed, asymmetric slopes go on growing"
        ),
        "stribeck": (
            "the uneven step is the same both ways, Stribeck friction turns with the direction"
        ),
    }
    motion = "speeds"
    next_motion = "drive the joint at constant speeds from creeping to 1 rad/s, each both ways"
    caution = "at speeds far above w it is a constant: only slow motion shows it"

    def columns(self, x: Inputs, joint: int, shape: Values) -> Floats:
        return np.tanh(x.qd[:, [joint]] / shape["w"]) ** 2
