"""The load that passes a gear, where it is not known which inertia lies before it."""

from collections.abc import Mapping

import numpy as np

from lagrangian_ff.effects.base import Floats, Shape
from lagrangian_ff.effects.inputs import Inputs

ROTOR = Shape(
    "Jr", "kg·m²", "inertia before the gear, which its load is free of", 1e-6, 1e3, 1e-3,
    of_model=True,
)  # fmt: skip
"""Of the model: it takes out what the model's load has too much of it, or too little."""
SHARES = (0.0, 0.25, 0.5, 0.75)
"""Of the inertia that a joint turns: so much of it may be the rotor's."""
LIKE = 0.05
"""Of that inertia, by which two of them differ too little to try both."""
MATTERS = 0.25
"""Times the load, from which on the torque of that inertia makes a difference."""


def link_load(x: Inputs, joint: int, shape: Mapping[str, float]) -> Floats:
    """(M,) N·m through the gear, free of the inertia Jr of a shape, or as the model has it."""
    taken = float(x.rotor[joint])
    return np.asarray(x.load[:, joint] + (taken - shape.get("Jr", taken)) * x.qdd[:, joint])


def rotors(x: Inputs, joint: int) -> list[float]:
    """kg·m² to try for Jr, that of the model first.

    The constant part of a joint's inertia may be the rotor's or the link's, which no motion tells.
    Where it takes little of the torque, that does not matter; on a vertical axis it does.
    """
    taken = float(np.clip(x.rotor[joint], ROTOR.low, ROTOR.high))
    speeding = float(np.mean(x.qdd[:, joint] ** 2))
    if speeding == 0.0:
        return [taken]
    of_load = float(np.mean(x.load[:, joint] * x.qdd[:, joint])) / speeding
    turned = taken + max(of_load, 0.0)
    if turned**2 * speeding < MATTERS**2 * float(np.mean(x.load[:, joint] ** 2)):
        return [taken]
    others = (share * turned for share in SHARES if abs(share * turned - taken) > LIKE * turned)
    return [taken, *(float(np.clip(one, ROTOR.low, ROTOR.high)) for one in others)]
