"""A cylinder or spring that carries the arm's weight."""

from collections.abc import Sequence
from itertools import product

import numpy as np

from lagrangian_ff.effects.base import Effect, Floats, Parameter, Shape, Values
from lagrangian_ff.effects.inputs import Inputs


class Counterbalance(Effect):
    """A cylinder of constant force between a pivot on the base and one on the link.

    With the pivots at distances 1 and r from the joint's axis and the angle q - q0 between them,
    its length is sqrt(1 + r² - 2 r cos(q - q0)), and the torque is force times the derivative of
    this length. A spring in its place adds to this what gravity's own form takes up.
    """

    name = "counterbalance"
    formula = "F sin(q - q0) / sqrt(1 + r^2 - 2 r cos(q - q0))"
    source = "law of cosines for a force between two pivots"
    meaning = "a cylinder or spring that carries the arm's weight"
    parameters = (Parameter("F", "N·m", "force times the link's lever arm"),)
    shapes = (
        Shape("r", "1", "lever arm on the link over that on the base", 0.1, 0.9, 0.5, steps=4),
        Shape("q0", "rad", "angle at which the pivots are in line", 0.1, 0.1 + 2.0 * np.pi, 3.0),
    )
    kind = "mechanics"
    part = "gravity"
    coordinate = "position"
    shows_as = "a smooth curve over position, unmoved by payload and speed"
    look_alikes = {
        "spring": "a counterbalance bends back within a turn, a spring grows with the angle",
        "ripple": "a counterbalance goes through one period in a turn, ripple through several",
    }
    motion = "payloads"
    next_motion = "sweep the whole range slowly with two payloads: it stays while gravity changes"
    caution = "a kernel that is free in position has it already: only models without find it"
    absorbed = True

    def columns(self, x: Inputs, joint: int, shape: Values) -> Floats:
        angle, r = x.q[:, joint] - shape["q0"], shape["r"]
        return (np.sin(angle) / np.sqrt(1.0 + r**2 - 2.0 * r * np.cos(angle)))[:, None]

    def energies(self, x: Inputs, joint: int, shape: Values) -> tuple[Floats, Floats]:
        angle, r = x.q[:, joint] - shape["q0"], shape["r"]
        length = np.sqrt(1.0 + r**2 - 2.0 * r * np.cos(angle))[:, None]
        return np.zeros_like(length), length / r

    def candidates(self, x: Inputs, joint: int) -> Sequence[Values]:
        """Return all lever arms with twelve angles around the turn."""
        angles = self.shapes[1].low + 2.0 * np.pi * np.arange(12) / 12
        pairs = product(self.shapes[0].grid(), angles.tolist())
        return [{"r": r, "q0": q0} for r, q0 in pairs]
