"""A joint that gives way under load."""

from collections.abc import Mapping
from typing import ClassVar

from lagrangian_ff.effects.base import Effect, Floats, Parameter
from lagrangian_ff.effects.inputs import Inputs

SMOOTHING = 0.1  # s: a fourth rate of position is made of noise where the motion is not smooth


class Elasticity(Effect):
    """The gear winds up by load / k, and what it winds up accelerates an inertia.

    First order in the compliance, with M the link's inertia and J the motor's. With the encoder on
    the motor, link and gravity follow load / k behind, and what no rigid arm explains of it is
    -M²/k times the fourth rate of position; gravity's part is that of a rigid arm with another
    inertia. With the encoder on the link the motor moves load / k ahead: +J M/k.

    The acceleration is smoothed over 0.1 s first: for motion slower than this the parameter is
    right, for faster motion too large.
    """

    name = "elasticity"
    formula = "a d²qdd/dt²"
    source = "Spong 1987, ASME J. Dyn. Syst. Meas. Control 109(4), expanded in 1/k"
    meaning = "a gear or joint that gives way under load"
    parameters = (
        Parameter("a", "kg·m²·s²", "-M²/k with the encoder on the motor, J M/k on the link"),
    )
    kind = "transmission"
    coordinate = "acceleration"
    shows_as = "an error that follows the second rate of change of the acceleration; resonance"
    look_alikes: ClassVar[Mapping[str, str]] = {
        "delay": "it is in step with the acceleration",
        "rotor_inertia": "it grows with the fourth power of frequency, not with the second",
        "backlash": "it is there wherever the joint jerks, not only where the load turns its sign",
        "hysteresis": "it is there wherever the joint jerks, not only after a reversal",
        "saturation": "it does not depend on the torque itself",
    }
    motion = "chirp"
    next_motion = "sweep the frequency up, at small amplitude; a second encoder shows it itself"
    remembers = True

    def columns(self, x: Inputs, joint: int, shape: Mapping[str, float]) -> Floats:
        """See `Effect.columns`."""
        return x.rate(x.rate(x.smoothed(x.qdd[:, [joint]], SMOOTHING)))
