"""Coulomb friction that differs by direction."""

import numpy as np

from lagrangian_ff.effects.base import Effect, Floats, Parameter, Values
from lagrangian_ff.effects.inputs import Inputs


class AsymmetricCoulomb(Effect):
    """Dry friction of one size forwards and another backwards.

    The smoothed step is split in two, (1 + sign) / 2 and (sign - 1) / 2, so that the columns span
    what Coulomb friction and an offset span, no more and no less.
    """

    name = "asymmetric_coulomb"
    formula = "F_p (sign(qd) + 1) / 2 + F_n (sign(qd) - 1) / 2"
    source = "Swevers, Verdonck and De Schutter 2007, IEEE Control Systems Magazine 27(5)"
    meaning = "dry friction of another size forwards than backwards"
    parameters = (
        Parameter("F_p", "N·m", "Coulomb torque of positive motion"),
        Parameter("F_n", "N·m", "Coulomb torque of negative motion"),
    )
    coordinate = "direction"
    shows_as = "a step at zero speed, higher on one side"
    look_alikes = {
        "coulomb": "the asymmetric step is higher one way; take the offset away and they are alike",
        "offset": "nothing in the motion: read the effort with the brake on",
    }
    motion = "reversals"
    next_motion = "reverse the joint slowly, many times; read the effort with the brake on"
    observable = False
    caution = "identical to coulomb plus offset: no motion tells them apart"

    def columns(self, x: Inputs, joint: int, shape: Values) -> Floats:
        sign = x.sign(joint)
        return np.stack([0.5 * (sign + 1.0), 0.5 * (sign - 1.0)], axis=1)
