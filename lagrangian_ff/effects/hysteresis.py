"""Presliding: friction that builds up over a distance."""

import numpy as np

from lagrangian_ff.effects.base import Effect, Floats, Parameter, Shape, Values
from lagrangian_ff.effects.inputs import Inputs
from lagrangian_ff.effects.memory import stop


class Hysteresis(Effect):
    """Friction that turns over within a distance after a reversal, as asperities bend first.

    One elastic contact that slides, minus the friction it settles at: nothing is left of it once
    the contact slides. Before a recording begins it is taken to slide already.
    """

    name = "hysteresis"
    formula = "F ((q - play(q, w)) / w - sign(qd))"
    source = (
        "Dahl 1968, Aerospace Corp. TOR-0158(3107-18)-1; with play operators: Krasnosel'skii and "
        "Pokrovskii 1989; Al-Bender, Lampaert and Swevers 2005, IEEE Trans. Autom. Control 50(11)"
    )
    meaning = "friction that builds up over a distance after a reversal (presliding)"
    parameters = (Parameter("F", "N·m", "friction that builds up so"),)
    shapes = (Shape("w", "rad", "deflection at which it slides", 3e-4, 3e-2, 3e-3),)
    coordinate = "since_reversal"
    shows_as = "loops over position after each reversal"
    look_alikes = {
        "stribeck": "hysteresis comes after a reversal only: creep without reversing",
        "coulomb": "hysteresis turns over within a distance after the reversal, Coulomb's at once",
    }
    motion = "reversals"
    next_motion = "reverse with strokes of 0.1 to 10 mrad, at two speeds"
    remembers = True

    def columns(self, x: Inputs, joint: int, shape: Values) -> Floats:
        settled = x.sign(joint)
        position, segment = np.ascontiguousarray(x.q[:, joint]), np.ascontiguousarray(x.segment)
        deflection = stop(position, segment, settled, shape["w"])
        return (deflection - settled)[:, None]
