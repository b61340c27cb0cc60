"""Friction that grows with the load on the gear."""

from collections.abc import Sequence

import numpy as np

from lagrangian_ff.effects.base import Effect, Floats, Parameter, Values
from lagrangian_ff.effects.gear import ROTOR, link_load, rotors
from lagrangian_ff.effects.inputs import Inputs


class _GearLoss(Effect):
    """A loss in proportion to the load that passes through a gear's teeth."""

    source = (
        "Gogoussis and Donath 1987, ICRA; Hamon, Gautier and Garrec 2010, IROS; "
        "Bittencourt and Gunnarsson 2012, ASME J. Dyn. Syst. Meas. Control 134(5)"
    )
    shapes = (ROTOR,)
    coordinate = "load"
    motion = "payloads"
    uses = frozenset({"load"})

    def candidates(self, x: Inputs, joint: int) -> Sequence[Values]:
        return [{"Jr": inertia} for inertia in rotors(x, joint)]


class LoadFriction(_GearLoss):
    """Dry friction in proportion to the torque that passes through the gear's teeth."""

    name = "load_friction"
    formula = "mu |load(Jr)| sign(qd)"
    meaning = "dry friction in proportion to the load on the gear"
    parameters = (Parameter("mu", "1", "friction torque over load torque"),)
    shows_as = "a step at zero speed whose height follows the load, whichever its sign"
    look_alikes = {
        "coulomb": "the step of load friction grows with the load, Coulomb's does not",
        "position_friction": (
            "load friction moves with the load, position friction stays: change the payload"
        ),
        "torque_gain": "load friction turns its sign with the direction, a torque gain does not",
    }
    next_motion = "repeat the same motion, with slow reversals under load, with two payloads"

    def columns(self, x: Inputs, joint: int, shape: Values) -> Floats:
        return (np.abs(link_load(x, joint, shape)) * x.sign(joint))[:, None]


class LoadViscous(_GearLoss):
    """Loss in proportion to speed and to the torque that passes through the gear."""

    name = "load_viscous"
    formula = "mu_v |load(Jr)| qd"
    meaning = "viscous friction in proportion to the load on the gear"
    parameters = (Parameter("mu_v", "s/rad", "viscous torque over load torque and speed"),)
    shows_as = "a slope over speed that is steeper under load"
    look_alikes = {
        "load_friction": "at one load load_viscous grows with speed, load_friction does not",
        "viscous": "the slope of load_viscous grows with the load, the viscous slope does not",
        "torque_gain": "load friction turns its sign with the direction, a torque gain does not",
    }
    next_motion = "repeat the same motion at two speeds, with two payloads"

    def columns(self, x: Inputs, joint: int, shape: Values) -> Floats:
        return (np.abs(link_load(x, joint, shape)) * x.qd[:, joint])[:, None]
