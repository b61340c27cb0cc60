"""A joint that gives way under load."""

from collections.abc import Sequence

import numpy as np

from lagrangian_ff.effects.base import Floats, Parameter, Shape, Values
from lagrangian_ff.effects.gear import OF, Gear
from lagrangian_ff.effects.memory import swinging

FASTEST = 0.4
"""The highest resonance that samples show, in parts of their frequency."""


class Elasticity(Gear):
    """A motor that turns its link through a spring with a little damping.

    With the encoder on the motor, a link of inertia M behind a spring k moves so that the gear
    carries not the load of the motor's motion but that load after a filter of second order,
    (2 z w s + w²) / (s² + 2 z w s + w²) with w² = k/M = (2 pi f)². This holds exactly where M is
    constant, resonance and all; slow loads such as gravity pass unchanged. With the encoder on the
    link nothing of the kind is seen.
    """

    name = "elasticity"
    formula = "c (resonant(load[of], f, z) - load[of]) + J (resonant(qdd[of], f, z) - qdd[of])"
    source = "Spong 1987, ASME J. Dyn. Syst. Meas. Control 109(4), its equations for one joint"
    meaning = "a gear or joint that gives way under load and swings"
    parameters = (
        Parameter("c", "1", "share of the load behind the spring, about 1", positive=True),
        Parameter("J", "kg·m²", "inertia behind the spring that was not counted into the load"),
    )
    shapes = (
        OF,
        Shape("f", "Hz", "resonance of the link on its spring", 1.5, 20.0, 6.0, 9, bounds=True),
        Shape("z", "1", "its damping, in parts of critical", 0.08, 0.3, 0.1, 2),
    )
    kind = "transmission"
    part = "inertia"
    coordinate = "acceleration"
    shows_as = "an error that rings at one frequency after every jerk"
    look_alikes = {
        "rotor_inertia": (
            "elasticity grows with the frequency's fourth power, a rotor with its square"
        ),
        "hysteresis": "elasticity comes at every jerk; hysteresis after reversals, however slow",
        "saturation": (
            "saturation comes at large torque, fast or slow; elasticity ignores the torque"
        ),
    }
    motion = "chirp"
    next_motion = "sweep the frequency up, at small amplitude; a second encoder shows it itself"
    rings = True

    def carried(self, load: Floats, part: Floats, step: float, shape: Values) -> Floats:
        w = 2.0 * np.pi * min(shape["f"], FASTEST / step)
        return swinging(part, step, w, shape["z"])

    def tried(self, load: Floats) -> Sequence[Values]:
        _, f, z = self.shapes
        return [{"f": hz, "z": damping} for hz in f.grid() for damping in z.grid()]
