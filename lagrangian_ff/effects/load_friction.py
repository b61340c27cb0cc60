"""Friction that grows with the load on the gear."""

from collections.abc import Mapping, Sequence
from typing import ClassVar

import numpy as np

from lagrangian_ff.effects.base import Effect, Floats, Parameter
from lagrangian_ff.effects.inputs import Inputs
from lagrangian_ff.effects.link_load import ROTOR, link_load, rotors


class _GearLoss(Effect):
    """What a gear loses in proportion to the load that passes through its teeth."""

    source = (
        "Gogoussis and Donath 1987, ICRA; Hamon, Gautier and Garrec 2010, IROS; "
        "Bittencourt and Gunnarsson 2012, ASME J. Dyn. Syst. Meas. Control 134(5)"
    )
    shapes = (ROTOR,)
    kind = "friction"
    coordinate = "load"
    motion = "payloads"
    uses = frozenset({"load"})

    def candidates(self, x: Inputs, joint: int) -> Sequence[Mapping[str, float]]:
        """See `rotors`."""
        return [{"Jr": inertia} for inertia in rotors(x, joint)]


class LoadFriction(_GearLoss):
    """Dry friction in proportion to the torque that passes through the gear's teeth."""

    name = "load_friction"
    formula = "mu |load(Jr)| sign(qd)"
    meaning = "dry friction in proportion to the load on the gear"
    parameters = (Parameter("mu", "1", "friction torque over load torque"),)
    shows_as = "a step at zero speed whose height follows the load, whichever its sign"
    look_alikes: ClassVar[Mapping[str, str]] = {
        "coulomb": "the step grows with the load",
        "position_friction": "it moves with the load, not with the position: change the payload",
        "load_viscous": "at one load it is the same at every speed",
        "torque_gain": "it turns its sign with the direction of motion",
        "gear_mesh": "it does not come and go within a turn",
    }
    next_motion = "repeat the same motion, with slow reversals under load, with two payloads"

    def columns(self, x: Inputs, joint: int, shape: Mapping[str, float]) -> Floats:
        """See `Effect.columns`."""
        return (np.abs(link_load(x, joint, shape)) * x.sign(joint))[:, None]


class LoadViscous(_GearLoss):
    """Loss in proportion to speed and to the torque that passes through the gear."""

    name = "load_viscous"
    formula = "mu_v |load(Jr)| qd"
    meaning = "viscous friction in proportion to the load on the gear"
    parameters = (Parameter("mu_v", "s/rad", "viscous torque over load torque and speed"),)
    shows_as = "a slope over speed that is steeper under load"
    look_alikes: ClassVar[Mapping[str, str]] = {
        "viscous": "the slope grows with the load",
        "load_friction": "at one load it grows with speed",
        "torque_gain": "it turns its sign with the direction of motion",
    }
    next_motion = "repeat the same motion at two speeds, with two payloads"

    def columns(self, x: Inputs, joint: int, shape: Mapping[str, float]) -> Floats:
        """See `Effect.columns`."""
        return (np.abs(link_load(x, joint, shape)) * x.qd[:, joint])[:, None]
