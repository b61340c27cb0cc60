"""A spring, a cable, a hose."""

from collections.abc import Mapping

import numpy as np

from lagrangian_ff.effects.base import Effect, Floats, Parameter, Values
from lagrangian_ff.effects.inputs import Inputs


class Spring(Effect):
    """A torque that pulls the joint back: a torsion spring, a hose or a cable that stiffens.

    The angle q0 at which the spring is at rest goes into an offset.
    """

    name = "spring"
    formula = "k q + k3 q^3"
    source = "Hooke's law and the stiffening term of Duffing's equation"
    meaning = "a spring, or a cable that pulls the joint back"
    parameters = (Parameter("k", "N·m/rad", "stiffness"), Parameter("k3", "N·m/rad³", "stiffening"))
    kind = "mechanics"
    part = "gravity"
    coordinate = "position"
    shows_as = "a smooth curve over position, the same both ways"
    look_alikes = {"offset": "a spring's torque changes with position, an offset does not"}
    motion = "slow sweep"
    next_motion = "sweep the whole range slowly, forth and back"
    caution = "a kernel that is free in position has it already: only models without find it"
    absorbed = True
    side_by_side = True

    def columns(self, x: Inputs, joint: int, shape: Values) -> Floats:
        q = x.q[:, joint]
        return np.stack([q, q**3], axis=1)

    def signs(self, x: Inputs, joint: int, shape: Values) -> Mapping[str, Floats]:
        """Return the slope over the positions visited: a spring does not push away from its rest.

        Far from q = 0 neither k nor k3 alone is the stiffness that was felt.
        """
        q = x.q[:, joint] - np.mean(x.q[:, joint])
        slope = q @ self.columns(x, joint, shape) / max(float(q @ q), 1e-300)
        return {"its mean stiffness in N·m/rad": slope}

    def energies(self, x: Inputs, joint: int, shape: Values) -> tuple[Floats, Floats]:
        q = x.q[:, joint]
        potential = np.stack([q**2 / 2.0, q**4 / 4.0], axis=1)
        return np.zeros_like(potential), potential
