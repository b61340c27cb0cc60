"""The load that passes a gear, where it is not known which inertia lies before it."""

from collections.abc import Mapping

import numpy as np

from lagrangian_ff.effects.base import Floats, Shape
from lagrangian_ff.effects.inputs import Inputs

ROTOR = Shape("Jr", "kg·m²", "inertia before the gear, which its load is free of", 1e-6, 1e3, 1e-3)
SHARES = (1.0, 0.75, 0.5, 0.25)
"""Of the inertia that is taken for the rotor's: it may be the link's in part."""
MATTERS = 0.25
"""Times the load, from which on the torque of that inertia makes a difference."""


def link_load(x: Inputs, joint: int, shape: Mapping[str, float]) -> Floats:
    """(M,) N·m through the gear, free of the inertia Jr of a shape, or as the model has it."""
    taken = float(x.rotor[joint])
    return np.asarray(x.load[:, joint] + (taken - shape.get("Jr", taken)) * x.qdd[:, joint])


def rotors(x: Inputs, joint: int) -> list[float]:
    """kg·m² to try for Jr.

    The constant part of a joint's inertia may be the rotor's or the link's, which no motion tells.
    Where it takes little of the torque, that does not matter; on a vertical axis it does.
    """
    taken = float(np.clip(x.rotor[joint], ROTOR.low, ROTOR.high))
    turning = taken**2 * float(np.mean(x.qdd[:, joint] ** 2))
    if turning < MATTERS**2 * float(np.mean(x.load[:, joint] ** 2)):
        return [taken]
    return [share * taken for share in SHARES if share * taken > ROTOR.low]
