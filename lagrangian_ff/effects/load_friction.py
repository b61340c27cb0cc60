"""Friction that grows with the load on the gear."""

from collections.abc import Sequence
from typing import ClassVar

import numpy as np

from lagrangian_ff.effects.base import Effect, Floats, Parameter, Shape, Values
from lagrangian_ff.effects.gear import ROTOR, link_load, rotors
from lagrangian_ff.effects.inputs import Inputs
from lagrangian_ff.effects.stribeck import creeping


class _GearLoss(Effect):
    """A loss in proportion to the load that passes through a gear's teeth."""

    source = (
        "Gogoussis and Donath 1987, ICRA; Hamon, Gautier and Garrec 2010, IROS; "
        "Bittencourt and Gunnarsson 2012, ASME J. Dyn. Syst. Meas. Control 134(5)"
    )
    shapes: ClassVar[tuple[Shape, ...]] = (ROTOR,)
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
    parameters = (Parameter("mu", "1", "friction torque over load torque", positive=True),)
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
    parameters = (
        Parameter("mu_v", "s/rad", "viscous torque over load torque and speed", positive=True),
    )
    shows_as = "a slope over speed that is steeper under load"
    look_alikes = {
        "load_friction": "at one load load_viscous grows with speed, load_friction does not",
        "viscous": "the slope of load_viscous grows with the load, the viscous slope does not",
        "torque_gain": "load friction turns its sign with the direction, a torque gain does not",
    }
    next_motion = "repeat the same motion at two speeds, with two payloads"

    def columns(self, x: Inputs, joint: int, shape: Values) -> Floats:
        return (np.abs(link_load(x, joint, shape)) * x.qd[:, joint])[:, None]


class LoadStribeck(_GearLoss):
    """Stribeck's bump in proportion to the torque that presses the gear's teeth together.

    With `load_friction` and `stribeck` it is the whole of a dry friction (a + b |load|) that falls
    with speed.
    """

    name = "load_stribeck"
    formula = "mu_s |load(Jr)| sign(qd) exp(-(qd / v_s)^2)"
    source = (
        "Duclusaud, Passault, Padois and Ly 2025, ICRA (BAM, model M4); Bittencourt and Gunnarsson "
        "2012, ASME J. Dyn. Syst. Meas. Control 134(5)"
    )
    meaning = "dry friction of a loaded gear that is higher while creeping"
    parameters = (
        Parameter("mu_s", "1", "static friction above Coulomb's over load torque", positive=True),
    )
    shapes = (
        Shape("v_s", "rad/s", "Stribeck velocity", 0.01, 1.0, 0.1, steps=4, bounds=True),
        ROTOR,
    )
    coordinate = "velocity"
    shows_as = "a bump on both sides of zero speed whose height follows the load"
    look_alikes = {
        "stribeck": "the bump of load_stribeck grows with the load, Stribeck's does not",
        "load_friction": "load_stribeck is gone at higher speed, load friction stays",
    }
    next_motion = "creep at 0.005 to 0.2 rad/s both ways, in postures of large and of small load"

    def columns(self, x: Inputs, joint: int, shape: Values) -> Floats:
        bump = np.exp(-((x.qd[:, joint] / shape["v_s"]) ** 2))
        return (np.abs(link_load(x, joint, shape)) * x.sign(joint) * bump)[:, None]

    def candidates(self, x: Inputs, joint: int) -> Sequence[Values]:
        """Return every speed with every inertia of `rotors`."""
        inertias = rotors(x, joint)
        speeds = creeping(self.shapes[0], x, joint)
        return [{"v_s": speed, "Jr": jr} for speed in speeds for jr in inertias]


class DirectionalFriction(_GearLoss):
    """The part of load friction that follows the motor's torque instead of the load's.

    Both press the teeth, mu_m |motor| + mu_l |load|. `load_friction` has the sum of the weights;
    this is what is left: the motor's torque exceeds the load's where it drives the load, and falls
    short of it where the load drives.
    """

    name = "directional_friction"
    formula = "mu_m (|torque - Jr qdd| - |load(Jr)|) sign(qd)"
    source = "Duclusaud, Passault, Padois and Ly 2025, ICRA (BAM, model M5)"
    meaning = "gear friction that is higher where the motor drives the load than where it is driven"
    parameters = (
        Parameter(
            "mu_m", "1", "friction torque over motor torque, beside that of load", positive=True
        ),
    )
    shows_as = "friction that is higher while lifting a load than while lowering it"
    look_alikes = {
        "load_friction": (
            "load friction grows with the load; directional friction jumps where the load turns "
            "its sign, as high as the joint's friction is"
        ),
        "torque_gain": "directional friction is in proportion to the friction, not to the load",
    }
    next_motion = "lift and lower several payloads at several speeds"
    caution = (
        "efficiencies that differ between driving and driven, in proportion to the load alone, are "
        "all masses scaled: what is seen is the friction that the motor's torque itself has"
    )
    uses = frozenset({"load", "torque"})

    def columns(self, x: Inputs, joint: int, shape: Values) -> Floats:
        load = link_load(x, joint, shape)
        before = shape.get("Jr", float(x.rotor[joint])) * x.qdd[:, joint]
        motor = x.torque[:, joint] - before
        return ((np.abs(motor) - np.abs(load)) * x.sign(joint))[:, None]
