"""Friction over the temperature that was measured."""

from collections.abc import Sequence

import numpy as np

from lagrangian_ff.effects.base import Effect, Floats, Parameter, Shape, Values
from lagrangian_ff.effects.inputs import Inputs

VARIES = 1.0
"""°C between the coldest and the warmest tenth, below which a recording says nothing."""


class TemperatureFriction(Effect):
    """Friction of a lubricant whose viscosity changes with the measured temperature of the joint.

    The exponential law of viscosity over a limited range; with a large D it is a straight line. At
    T0, the mean of the recording that it was found on, nothing is left of it: the model's Coulomb
    and viscous friction are those at T0. So are they where no temperature was measured.
    """

    name = "temperature_friction"
    formula = "(F_T sign(qd) + B_T qd) (exp((T0 - temperature) / D) - 1)"
    source = (
        "Bittencourt, Wernholt, Sander-Tavallaey and Brogårdh 2010, IROS; Gao, Yuan, Han, Wang and "
        "Wang 2017, Mechanism and Machine Theory: friction of robot joints over temperature"
    )
    meaning = "friction that follows the measured temperature"
    parameters = (
        Parameter("F_T", "N·m", "dry friction at T0 that thins out with warmth"),
        Parameter("B_T", "N·m·s/rad", "viscous coefficient at T0 that thins out with warmth"),
    )
    shapes = (
        Shape("D", "°C", "warming by which it falls to 1/e", 5.0, 200.0, 30.0, steps=3),
        Shape("T0", "°C", "temperature at which the model's friction holds", 1e-3, 200.0, 25.0),
    )
    coordinate = "time"
    shows_as = "friction that changes with the measured temperature, while gravity stays"
    look_alikes = {
        "warm_up": "friction over temperature follows the thermometer, warming up only the clock"
    }
    motion = "warm-up"
    next_motion = (
        "record temperature/<joint> with the motion, from cold until the error no longer changes"
    )

    def columns(self, x: Inputs, joint: int, shape: Values) -> Floats:
        """Return the columns; zero where there is no temperature."""
        colder = shape["T0"] - x.temperature_of(joint)
        factor = np.expm1(np.where(np.isfinite(colder), colder, 0.0) / shape["D"])
        return np.stack([factor * x.sign(joint), factor * x.qd[:, joint]], axis=1)

    def candidates(self, x: Inputs, joint: int) -> Sequence[Values]:
        """Return every D about the mean temperature; nothing without one that varies."""
        measured = (x.whole or x).temperature_of(joint)
        if not np.isfinite(measured).all():
            return []
        cold, warm = np.quantile(measured, (0.1, 0.9))
        mean = float(np.clip(measured.mean(), self.shapes[1].low, self.shapes[1].high))
        if warm - cold < VARIES:
            return []
        return [{"D": fall, "T0": mean} for fall in self.shapes[0].grid()]
