"""Viscous friction that differs by direction."""

import numpy as np

from lagrangian_ff.effects.base import Effect, Floats, Parameter, Values
from lagrangian_ff.effects.inputs import Inputs


class AsymmetricViscous(Effect):
    """Loss in proportion to speed, with one slope forwards and another backwards."""

    name = "asymmetric_viscous"
    formula = "B_p max(qd, 0) + B_n min(qd, 0)"
    source = (
        "Armstrong-Hélouvry, Dupont and Canudas de Wit 1994, Automatica 30(7): friction differs "
        "by direction"
    )
    meaning = "viscous friction of another slope forwards than backwards"
    parameters = (
        Parameter("B_p", "N·m·s/rad", "viscous coefficient of positive motion"),
        Parameter("B_n", "N·m·s/rad", "viscous coefficient of negative motion"),
    )
    shows_as = "a kink at zero speed"
    look_alikes = {
        "viscous": "asymmetric slopes differ by direction, the viscous slope is the same both ways",
        "quadratic_drag": (
            "asymmetric branches are straight and differ; drag is curved and symmetric"
        ),
    }
    motion = "speeds"
    next_motion = "drive the joint at several constant speeds, each both ways, up to its limit"

    def columns(self, x: Inputs, joint: int, shape: Values) -> Floats:
        speed = x.qd[:, joint]
        return np.stack([np.maximum(speed, 0.0), np.minimum(speed, 0.0)], axis=1)
