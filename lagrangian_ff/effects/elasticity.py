"""A joint that gives way under load."""

from collections.abc import Mapping
from typing import ClassVar

from lagrangian_ff.effects.base import Effect, Floats, Parameter
from lagrangian_ff.effects.inputs import Inputs

SMOOTHING = 0.1  # s: a second rate is made of noise where the load is not smooth


class Elasticity(Effect):
    """The gear winds up by load / k, and what it winds up accelerates an inertia.

    First order in the compliance. With the encoder on the link the motor's inertia J moves by
    load / k more than is measured, and the parameter is J / k; with the encoder on the motor it is
    the link's that moves by as much less, and the parameter is minus the link's inertia over k.
    The load is smoothed over 0.1 s first: slower than this the parameter is right, faster motion
    gives too large a one.
    """

    name = "elasticity"
    formula = "a d²load/dt²"
    source = "Spong 1987, ASME J. Dyn. Syst. Meas. Control 109(4)"
    meaning = "a gear or joint that gives way under load"
    parameters = (
        Parameter("a", "s²", "inertia over stiffness; negative: the encoder is on the motor"),
    )
    kind = "transmission"
    coordinate = "acceleration"
    shows_as = "an error that follows the second rate of change of the load; resonance"
    look_alikes: ClassVar[Mapping[str, str]] = {
        "delay": "it grows with the square of frequency, not in proportion to it",
        "rotor_inertia": "it follows gravity's changes too, not the acceleration alone",
        "backlash": "it is there wherever the load changes, not only where it turns its sign",
        "saturation": "it does not depend on the torque itself",
    }
    motion = "chirp"
    next_motion = "sweep the frequency up, at small amplitude; a second encoder shows it itself"
    remembers = True
    uses = frozenset({"load"})

    def columns(self, x: Inputs, joint: int, shape: Mapping[str, float]) -> Floats:
        """See `Effect.columns`."""
        return x.rate(x.rate(x.smoothed(x.load[:, [joint]], SMOOTHING)))
