"""The interface of effects in the joints of the plant, and the friction of the drives."""

from typing import NamedTuple, Protocol

import numpy as np

from lagrangian_ff.arm.parameters import ArmParameters
from lagrangian_ff.arrays import Floats


class JointMoment(NamedTuple):
    """The state of the joints that an effect sees, (6,) each, on the link's side of the gear.

    Attributes:
        time: s since the reset.  dt: s, the step of the integration.
        q: rad.  qd: rad/s.
        motor: N·m of the motor through the gear during this step.
        load: N·m that went into the links in the step before.
    """

    time: float
    dt: float
    q: Floats
    qd: Floats
    motor: Floats
    load: Floats


class JointEffect(Protocol):
    """A physical effect in the joints of the plant, perhaps with a state.

    The plant integrates implicitly in velocity: within one step it may ask for the torque at
    several velocities, and then advances the state once.
    """

    def reset(self, q: Floats) -> None:
        """Reset the state, if any; the arm rests at q, (6,) rad."""
        return

    def torque(self, moment: JointMoment) -> tuple[Floats, Floats]:
        """Return the torque that the motor must supply for the effect; the state stays.

        Returns:
            (6,) N·m, positive where it resists positive motion, and
            (6,) N·m·s/rad ≥ 0, a slope over velocity: for what dissipates the chord
            torque / qd, otherwise the derivative; zeros if it does not depend on velocity.
            The slope only steers the iteration, not the result.
        """

    def advance(self, moment: JointMoment) -> None:
        """Advance the state, if any, by one step; the moment has q and qd at its end."""
        return


class Friction:
    """Viscous and Coulomb friction, B qd + F tanh(qd / v), joint by joint."""

    def __init__(self, parameters: ArmParameters) -> None:
        self._viscous = np.asarray(parameters.viscous)
        self._coulomb = np.asarray(parameters.coulomb)
        self._per_velocity = 1.0 / np.asarray(parameters.coulomb_velocity)

    @property
    def numbers(self) -> dict[str, Floats]:
        """Return the parameters of the loops in C, (6,) each."""
        return {
            "viscous": self._viscous,
            "steepest": self._coulomb * self._per_velocity,
            "per_velocity": self._per_velocity,
        }

    def at(self, qd: Floats) -> Floats:
        """Return the torque at velocities (..., 6) rad/s, in N·m."""
        return self._viscous * qd + self._coulomb * np.tanh(qd * self._per_velocity)
