"""A torque that is measured too large or too small."""

from collections.abc import Mapping
from typing import ClassVar

from lagrangian_ff.effects.base import Effect, Floats, Parameter
from lagrangian_ff.effects.inputs import Inputs


class TorqueGain(Effect):
    """An error of the torque constant: the measured torque is the true one times 1 + g."""

    name = "torque_gain"
    formula = "g load"
    source = "Gautier and Briot 2014, ASME J. Dyn. Syst. Meas. Control 136(5)"
    meaning = "torque constant in error: all torque of the joint by a factor"
    parameters = (Parameter("g", "1", "torque constant over what was assumed, minus one"),)
    kind = "measurement"
    coordinate = "load"
    shows_as = "a straight line over the load torque"
    look_alikes: ClassVar[Mapping[str, str]] = {
        "load_friction": "it is the same in both directions of motion",
        "load_viscous": "it is the same in both directions of motion",
        "rotor_inertia": "it follows gravity too, not the acceleration alone",
        "payload": "it is there from the beginning to the end",
        "eccentricity": "it is the same at every position",
    }
    motion = "payloads"
    next_motion = "repeat the same motion with a payload of known mass"
    caution = (
        "identical to all masses scaled, so that a model identified from the same torques has it "
        "already; only a known payload, or another recording, shows it"
    )
    uses = frozenset({"load"})

    def columns(self, x: Inputs, joint: int, shape: Mapping[str, float]) -> Floats:
        """See `Effect.columns`."""
        return x.load[:, [joint]]
