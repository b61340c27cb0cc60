"""The motor's own inertia."""

import numpy as np

from lagrangian_ff.effects.base import Effect, Floats, Parameter, Values
from lagrangian_ff.effects.inputs import Inputs


class RotorInertia(Effect):
    """The rotor's inertia times the gear ratio squared, as the joint feels it."""

    name = "rotor_inertia"
    formula = "J qdd"
    source = "Spong, Hutchinson and Vidyasagar 2006, Robot Modeling and Control, ch. 7"
    meaning = "the motor's own inertia, reflected through the gear"
    parameters = (
        Parameter("J", "kg·m²", "inertia of the rotor times the gear ratio squared", positive=True),
    )
    kind = "mechanics"
    part = "inertia"
    coordinate = "acceleration"
    shows_as = "a straight line over the joint's own acceleration"
    look_alikes = {
        "torque_gain": "a rotor's torque follows the acceleration alone, a torque gain gravity too"
    }
    motion = "exciting"
    next_motion = "accelerate the joint in postures in which the links' inertia differs"
    observable = False
    caution = "a Lagrangian kernel has it already: only rigid-body (URDF) models without find it"
    side_by_side = True

    def columns(self, x: Inputs, joint: int, shape: Values) -> Floats:
        return x.qdd[:, [joint]]

    def energies(self, x: Inputs, joint: int, shape: Values) -> tuple[Floats, Floats]:
        kinetic = 0.5 * x.qd[:, [joint]] ** 2
        return kinetic, np.zeros_like(kinetic)
