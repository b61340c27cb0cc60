"""Torque that repeats over the turn: cogging and ripple, gear mesh."""

from collections.abc import Sequence

import numpy as np

from lagrangian_ff.effects.base import Effect, Floats, Parameter, Shape, Values
from lagrangian_ff.effects.gear import ROTOR, link_load, rotors
from lagrangian_ff.effects.inputs import Inputs

ORDER = Shape("order", "1", "periods in one turn of the joint", 2, 60, 6, whole=True, bounds=True)


class Ripple(Effect):
    """Cogging of magnets against teeth, torque ripple: it repeats over the turn, moving or not."""

    name = "ripple"
    formula = "a cos(order q) + b sin(order q)"
    source = "Jahns and Soong 1996, IEEE Trans. Industrial Electronics 43(2)"
    meaning = "cogging or torque ripple, periodic in the joint's angle"
    parameters = (
        Parameter("a", "N·m", "amplitude of the cosine"),
        Parameter("b", "N·m", "amplitude of the sine"),
    )
    shapes = (ORDER,)
    kind = "transmission"
    part = "gravity"
    coordinate = "order"
    shows_as = "a line in the spectrum over position, the same in both directions"
    motion = "slow sweep"
    next_motion = "turn slowly through the whole range, with 20 samples or more a period"

    def columns(self, x: Inputs, joint: int, shape: Values) -> Floats:
        return turning(x.q[:, joint], shape["order"])

    def energies(self, x: Inputs, joint: int, shape: Values) -> tuple[Floats, Floats]:
        cosine, sine = turning(x.q[:, joint], shape["order"]).T
        potential = np.stack([sine, -cosine], axis=1) / shape["order"]
        return np.zeros_like(potential), potential


class GearMesh(Effect):
    """An error of the teeth, or the two lobes of a harmonic drive: it grows with the load."""

    name = "gear_mesh"
    formula = "|load(Jr)| (a cos(order q) + b sin(order q))"
    source = "Tuttle and Seering 1996, IEEE Trans. Robotics and Automation 12(3)"
    meaning = "gear error, periodic in the joint's angle and in proportion to the load"
    parameters = (
        Parameter("a", "1", "amplitude of the cosine over the load"),
        Parameter("b", "1", "amplitude of the sine over the load"),
    )
    shapes = (ORDER, ROTOR)
    kind = "transmission"
    part = "gravity"
    coordinate = "order"
    shows_as = "a line in the spectrum over position that grows with the load"
    look_alikes = {
        "load_friction": "gear mesh is the same both ways, and comes and goes within a turn",
        "ripple": "the amplitude of gear mesh grows with the load, that of ripple does not",
    }
    motion = "payloads"
    next_motion = "turn slowly through the whole range, with and without a payload"
    uses = frozenset({"load"})

    def columns(self, x: Inputs, joint: int, shape: Values) -> Floats:
        load = np.abs(link_load(x, joint, shape))
        return load[:, None] * turning(x.q[:, joint], shape["order"])

    def candidates(self, x: Inputs, joint: int) -> Sequence[Values]:
        """Return every order with every inertia of `rotors`."""
        inertias = rotors(x, joint)
        return [{"order": order, "Jr": jr} for order in ORDER.grid() for jr in inertias]


def turning(q: Floats, order: float) -> Floats:
    """Return (M, 2) cosine and sine of an order of the angle."""
    return np.stack([np.cos(order * q), np.sin(order * q)], axis=1)
