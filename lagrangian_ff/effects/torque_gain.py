"""A torque that is measured too large or too small."""

from lagrangian_ff.effects.base import Effect, Floats, Parameter, Values
from lagrangian_ff.effects.inputs import Inputs


class TorqueGain(Effect):
    """An error of the torque constant: the measured torque is the true one times 1 + g."""

    name = "torque_gain"
    formula = "g load"
    source = "Gautier and Briot 2014, ASME J. Dyn. Syst. Meas. Control 136(5)"
    meaning = "torque constant in error: all torque of the joint by a factor"
    parameters = (Parameter("g", "1", "torque constant over what was assumed, minus one"),)
    kind = "measurement"
    part = "gravity"
    coordinate = "load"
    shows_as = "a straight line over the load torque"
    motion = "payloads"
    next_motion = "repeat the same motion with a payload of known mass"
    observable = False
    caution = (
        "identical to all masses scaled, so that a model identified from the same torques has it "
        "already; only a known payload, or another recording, shows it"
    )
    uses = frozenset({"load"})

    def columns(self, x: Inputs, joint: int, shape: Values) -> Floats:
        return x.load[:, [joint]]
