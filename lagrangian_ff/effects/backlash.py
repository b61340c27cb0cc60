"""Play in the gear."""

from collections.abc import Mapping
from typing import ClassVar

import numpy as np

from lagrangian_ff.effects.base import Effect, Floats, Parameter, Shape
from lagrangian_ff.effects.inputs import Inputs
from lagrangian_ff.effects.memory import lag


class Backlash(Effect):
    """Teeth that lose contact when the load torque reverses, cross the gap, and hit.

    How it hits depends on inertias and speeds that joint states do not tell; the columns are a
    pulse that dies away after the reversal and one that rises first, both towards the new load.
    """

    name = "backlash"
    formula = "sign(load) (A + D t_rev / T) exp(-t_rev / T)"
    source = "Nordin and Gutman 2002, Automatica 38(10), for what happens; the pulses are ours"
    meaning = "play in the gear: a blow after each reversal of the load"
    parameters = (
        Parameter("A", "N·m", "pulse that starts with the reversal"),
        Parameter("D", "N·m", "pulse that rises after the reversal"),
    )
    shapes = (Shape("T", "s", "how long the blow lasts", 0.004, 0.15, 0.02),)
    kind = "transmission"
    coordinate = "load"
    shows_as = "spikes just after the load torque turns its sign"
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
        side = np.sign(x.load[:, joint])
        falling = 0.5 * (side - lag(side, x.time, x.segment, shape["T"]))
        rising = lag(falling, x.time, x.segment, shape["T"])
        return np.stack([falling, rising], axis=1)
