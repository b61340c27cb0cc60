"""Play in the gear."""

from collections.abc import Sequence

import numpy as np

from lagrangian_ff.effects.base import Floats, Parameter, Shape, Values
from lagrangian_ff.effects.gear import OF, Gear
from lagrangian_ff.effects.memory import loose

BLOW = 0.02  # s, in which teeth that hit pass on what the motor has gained
CROSSINGS = np.geomspace(BLOW, 0.2, 7)
"""s that the load, at its root mean square, takes to cross the gaps that are tried.

A servo's play of two degrees takes 0.2 s where the load accelerates its link by 1.7 rad/s². A gap
that is crossed before the blow is over shows nothing that a soft gear does not."""


class Backlash(Gear):
    """Teeth that lose contact when the load torque reverses, cross the gap, and hit.

    While they cross, the motor does not feel the load; it runs ahead of the link by M d²gap/dt² =
    load. When they hit, the momentum it gained on the way comes back as a blow. Only the product P
    of inertia and width matters.
    """

    name = "backlash"
    formula = "c (loose(load[of], P) - load[of]) + J (loose(qdd[of], P) - qdd[of])"
    source = "two masses with a dead zone, as in Nordin and Gutman 2002, Automatica 38(10)"
    meaning = "play in the gear: the load is let go and caught again when it reverses"
    parameters = (
        Parameter("c", "1", "share of the load that is let go, about 1", positive=True),
        Parameter("J", "kg·m²", "inertia beyond the gap that was not counted into the load"),
    )
    shapes = (
        OF,
        Shape("P", "kg·m²·rad", "the link's inertia times the play", 1e-9, 1e3, 1e-3, bounds=True),
    )
    kind = "transmission"
    part = "inertia"
    coordinate = "load"
    shows_as = "a hole and a blow where the load torque turns its sign"
    look_alikes = {
        "hysteresis": "backlash follows reversals of the load torque, hysteresis of the motion",
        "delay": "backlash comes only where the load turns its sign, a delay where torque changes",
        "elasticity": "backlash comes only where the load turns its sign, elasticity at every jerk",
    }
    motion = "reversals"
    next_motion = (
        "reverse the load torque often: small motions about the posture in which gravity vanishes; "
        "a second encoder shows the gap itself"
    )

    def carried(self, load: Floats, part: Floats, step: float, shape: Values) -> Floats:
        return np.asarray(loose(load, part, step, shape["P"], BLOW))

    def tried(self, load: Floats) -> Sequence[Values]:
        """Return gaps that this load crosses in a moment."""
        sizes = (float(np.sqrt(np.mean(load**2))) * CROSSINGS**2).tolist()
        _, play = self.shapes
        return [{"P": size} for size in sizes if play.low < size < play.high]
