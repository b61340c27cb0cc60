"""The model as set-points ask for it: one state at a time, a thousand times a second."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lagrangian_ff.identification import Model
from lagrangian_ff.identification.pointwise import Pointwise

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class OneState:
    """The parts of the torque at one state, (1, N) in N·m; see `plan.TermTorques`."""

    gravity: Floats
    inertia: Floats
    coriolis: Floats
    effects: Mapping[str, Floats]


class OneAtATime:
    """A model in the form that is quickest for one state; see `plan.InverseDynamics`.

    For one thread.

    Args:
        model: whose torques.
    """

    def __init__(self, model: Model) -> None:
        self.joints, self.range = model.joints, model.range
        self._pointwise = Pointwise(model)
        middle = 0.5 * (model.range.q_low + model.range.q_high)[None]
        self.terms(middle, 0.0 * middle, 0.0 * middle)  # what is made on first use is made now

    def terms(self, q: Floats, qd: Floats, qdd: Floats) -> OneState:
        """The parts at one state, (1, N) each."""
        found = self._pointwise.terms(q[0], qd[0], qdd[0])
        effects = {name: torque[None] for name, torque in found.effects.items()}
        return OneState(found.gravity[None], found.inertia[None], found.coriolis[None], effects)
