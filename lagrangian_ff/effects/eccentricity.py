"""An encoder that is mounted off its centre."""

from lagrangian_ff.effects.base import Effect, Floats, Parameter, Values
from lagrangian_ff.effects.inputs import Inputs
from lagrangian_ff.effects.ripple import turning


class Eccentricity(Effect):
    """An encoder that reports q + e cos(q + phase), once round in a turn; first order in e.

    In the reported angle the arm is a Lagrangian system still, whose generalised torque is the
    true one times dq/dq_reported by virtual work. What no Lagrangian can explain is the difference:
    the load times the derivative of the error, -e sin(q + phase).
    """

    name = "eccentricity"
    formula = "load (a cos(q) + b sin(q))"
    source = "virtual work in the reported angle; first order in the error"
    meaning = "an encoder off its centre: an error of angle once in a turn"
    parameters = (
        Parameter("a", "rad", "-e sin(phase) of the encoder's error e cos(q + phase)"),
        Parameter("b", "rad", "-e cos(phase)"),
    )
    kind = "measurement"
    part = "gravity"
    coordinate = "position"
    shows_as = "the load torque too large on one half of the turn, too small on the other"
    look_alikes = {
        "torque_gain": "eccentricity turns its sign within a turn, a torque gain does not",
        "gear_mesh": "eccentricity has one period in a turn and the load's sign, gear mesh several",
    }
    motion = "exciting"
    next_motion = "move the joint through its whole turn at several speeds; compare encoders"
    observable = False
    caution = "a universal kernel takes up most of it: mechanics in a bent coordinate are mechanics"
    uses = frozenset({"load"})

    def columns(self, x: Inputs, joint: int, shape: Values) -> Floats:
        return x.load[:, [joint]] * turning(x.q[:, joint], 1.0)
