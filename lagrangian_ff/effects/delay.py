"""Torque and position that are not of the same moment."""

from collections.abc import Mapping
from typing import ClassVar

from lagrangian_ff.effects.base import Effect, Floats, Parameter
from lagrangian_ff.effects.inputs import Inputs


class Delay(Effect):
    """The torque is reported late against the position, by a few milliseconds: first order."""

    name = "delay"
    formula = "d (-dtorque/dt)"
    source = "Taylor's theorem for torque(t - d)"
    meaning = "torque reported late against position"
    parameters = (Parameter("d", "s", "delay of torque; negative: of position"),)
    kind = "measurement"
    coordinate = "since_reversal"
    shows_as = "an error that follows the rate of change of the torque; spikes at reversals"
    look_alikes: ClassVar[Mapping[str, str]] = {
        "coulomb": "the error at reversals grows with the rate of the torque",
        "stribeck": "slow motion without reversals does not show it",
        "hysteresis": "its length is a time, not a distance: reverse at two speeds",
        "backlash": "it is there wherever the torque changes, not only where the load reverses",
        "elasticity": "it is a quarter of a period out of step with the acceleration",
        "coupled": "it comes where the torque changes, whatever two joints' speeds add up to",
    }
    motion = "chirp"
    next_motion = "sweep the frequency up, at small amplitude"
    remembers = True
    uses = frozenset({"torque"})

    def columns(self, x: Inputs, joint: int, shape: Mapping[str, float]) -> Floats:
        """See `Effect.columns`."""
        return -x.rate(x.torque[:, [joint]])
