"""Torque and position that are not of the same moment."""

from lagrangian_ff.effects.base import Effect, Floats, Parameter, Values
from lagrangian_ff.effects.inputs import Inputs


class Delay(Effect):
    """The torque is reported late against the position, by a few milliseconds: first order."""

    name = "delay"
    formula = "d (-dtorque/dt)"
    source = "Taylor's theorem for torque(t - d)"
    meaning = "torque reported late against position"
    parameters = (Parameter("d", "s", "delay of torque; negative: of position"),)
    kind = "measurement"
    part = "inertia"
    coordinate = "since_reversal"
    shows_as = "an error that follows the rate of change of the torque; spikes at reversals"
    look_alikes = {
        "coulomb": "at reversals a delay's error grows with the torque's rate, Coulomb's does not",
        "stribeck": (
            "a delay depends on how fast the torque changes: slow motion without reversals shows "
            "Stribeck friction only"
        ),
        "hysteresis": "a delay lasts for a time, hysteresis for a distance: reverse at two speeds",
        "elasticity": (
            "a delay is a quarter of a period out of step with the acceleration; elasticity is in "
            "step with the load below its resonance"
        ),
    }
    motion = "chirp"
    next_motion = "sweep the frequency up, at small amplitude"
    remembers = True
    uses = frozenset({"torque"})

    def columns(self, x: Inputs, joint: int, shape: Values) -> Floats:
        return -x.rate(x.torque[:, [joint]])
