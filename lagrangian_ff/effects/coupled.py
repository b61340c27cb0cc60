"""Friction of two joints that share a shaft."""

from collections.abc import Mapping, Sequence

import numpy as np

from lagrangian_ff.effects.base import Effect, Floats, Parameter, Shape, Values
from lagrangian_ff.effects.inputs import Inputs
from lagrangian_ff.errors import EffectError


class Coupled(Effect):
    """Friction on the sum or difference of two joints' speeds: a differential wrist.

    By virtual work the same torque, times the ratio, acts on the partner: both joints feel it.
    """

    name = "coupled"
    formula = "F sign(qd + ratio qd[partner]) + B (qd + ratio qd[partner])"
    source = "Janot, Vandanjon and Gautier 2014, IEEE Trans. Control Systems Technology 22(1)"
    meaning = "friction of a shaft that turns with two joints, as in a differential wrist"
    parameters = (
        Parameter("F", "N·m", "Coulomb torque of the shared shaft", positive=True),
        Parameter("B", "N·m·s/rad", "viscous coefficient of the shared shaft", positive=True),
    )
    shapes = (
        Shape("partner", "1", "the other joint", 0, 63, 0, whole=True, joint=True),
        Shape("ratio", "1", "turns of the shaft per turn of the partner", -1, 1, 1, whole=True),
    )
    kind = "transmission"
    shows_as = "steps where the sum or difference of two joints' speeds is zero"
    look_alikes = {
        "coulomb": (
            "the coupled step moves with the neighbour's speed; Coulomb's comes where this joint "
            "reverses, whatever its neighbours do"
        ),
        "delay": "the coupled step comes where two speeds cancel, a delay where the torque changes",
    }
    motion = "one by one"
    next_motion = "move the two joints one by one, then both at once at several ratios of speed"

    def columns(self, x: Inputs, joint: int, shape: Values) -> Floats:
        """Return the columns; raise EffectError if there is no such partner."""
        partner = round(shape["partner"])
        if not 0 <= partner < x.joints or partner == joint:
            raise EffectError(
                f"effect '{self.name}': joint {partner} is no partner of joint {joint}; expected "
                f"another of 0 to {x.joints - 1}"
            )
        speed = self.speed(x, joint, shape)
        return np.stack([np.tanh(speed / x.sign_speed[joint]), speed], axis=1)

    def others(self, joint: int, shape: Values) -> Mapping[int, float]:
        return {round(shape["partner"]): shape["ratio"]}

    def speed(self, x: Inputs, joint: int, shape: Values) -> Floats:
        return np.asarray(x.qd[:, joint] + shape["ratio"] * x.qd[:, round(shape["partner"])])

    def candidates(self, x: Inputs, joint: int) -> Sequence[Values]:
        """Return every other joint, with the sum of the speeds and with their difference."""
        return [
            {"partner": float(partner), "ratio": ratio}
            for partner in range(x.joints)
            if partner != joint
            for ratio in (1.0, -1.0)
        ]
