"""Play in the gear."""

from collections.abc import Mapping
from typing import ClassVar

import numpy as np

from lagrangian_ff.effects.base import Effect, Floats, Parameter, Shape
from lagrangian_ff.effects.inputs import Inputs

NOISE = 0.04  # s over which the load is smoothed, so that noise does not turn its sign
BLOW = 0.015  # s, what is faster than this is the motor's own motion and not the link's


class Backlash(Effect):
    """Teeth that lose contact when the load torque reverses, cross the gap, and hit.

    While it crosses, the motor runs ahead alone: around each reversal of the load, the sudden part
    of the acceleration that its encoder shows does not move the link, whose inertia a model without
    play charges for it. The sudden part is what a smoothing over 15 ms takes away.
    """

    name = "backlash"
    formula = "-J near(load reversal, T) sudden(qdd)"
    source = "two masses with a dead zone, as in Nordin and Gutman 2002, Automatica 38(10)"
    meaning = "play in the gear: the motor runs ahead alone when the load reverses"
    parameters = (Parameter("J", "kg·m²", "inertia that does not follow the motor in the gap"),)
    shapes = (Shape("T", "s", "how near a reversal of the load", 0.05, 0.4, 0.15, steps=4),)
    kind = "transmission"
    coordinate = "load"
    shows_as = "spikes, up and down, where the load torque turns its sign"
    look_alikes: ClassVar[Mapping[str, str]] = {
        "hysteresis": "it follows reversals of the load torque, not of the motion",
        "delay": "it comes only where the load turns its sign, not wherever it changes",
        "elasticity": "it comes only where the load turns its sign",
    }
    motion = "reversals"
    next_motion = (
        "reverse the load torque often: small motions about the posture in which gravity vanishes; "
        "a second encoder shows the gap itself"
    )
    remembers = True
    uses = frozenset({"load"})

    def columns(self, x: Inputs, joint: int, shape: Mapping[str, float]) -> Floats:
        """See `Effect.columns`."""
        side = np.where(x.smoothed(x.load[:, joint], NOISE) > 0.0, 1.0, -1.0)
        near = 1.0 - np.abs(x.smoothed(side, shape["T"]))
        sudden = x.qdd[:, joint] - x.smoothed(x.qdd[:, joint], BLOW)
        return np.asarray(-near * sudden)[:, None]
