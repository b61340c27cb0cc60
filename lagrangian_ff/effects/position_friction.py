"""Friction that changes with position."""

import numpy as np

from lagrangian_ff.effects.base import Effect, Floats, Parameter, Values
from lagrangian_ff.effects.inputs import Inputs


class PositionFriction(Effect):
    """Dry friction that rises and falls once in a turn: a bent shaft, an uneven seal or bearing."""

    name = "position_friction"
    formula = "sign(qd) (a cos(q) + b sin(q))"
    source = (
        "Armstrong-Hélouvry, Dupont and Canudas de Wit 1994, Automatica 30(7): "
        "position-dependent friction"
    )
    meaning = "dry friction that changes with position, once in a turn"
    parameters = (
        Parameter("a", "N·m", "amplitude of the cosine"),
        Parameter("b", "N·m", "amplitude of the sine"),
    )
    coordinate = "position"
    shows_as = "a step at zero speed whose height changes with position"
    look_alikes = {
        "coulomb": "the step of position friction changes with position, Coulomb's does not",
        "ripple": "position friction turns its sign with the direction, ripple does not",
    }
    motion = "slow sweep"
    next_motion = "sweep the whole range forth and back at one speed"

    def columns(self, x: Inputs, joint: int, shape: Values) -> Floats:
        q = x.q[:, joint]
        return x.sign(joint)[:, None] * np.stack([np.cos(q), np.sin(q)], axis=1)
