"""Presliding: friction that builds up over a distance."""

from collections.abc import Mapping

import numpy as np

from lagrangian_ff.effects.base import Effect, Floats, Parameter, Shape, Values
from lagrangian_ff.effects.inputs import Inputs
from lagrangian_ff.effects.memory import stop

MULTIPLES = (1.0, 3.0, 9.0)
"""Deflections at which the contacts slide, relative to the first."""


class Hysteresis(Effect):
    """Friction that turns over within a distance after a reversal, as asperities bend first.

    Elastic contacts in parallel that slide one after the other, minus the friction they settle at:
    nothing is left of one once it slides. Before a recording begins they are taken to slide.
    """

    name = "hysteresis"
    formula = "F_1 s(w) + F_2 s(3*w) + F_3 s(9*w), with s(u) = (q - play(q, u)) / u - sign(qd)"
    source = (
        "Dahl 1968, Aerospace Corp. TOR-0158(3107-18)-1; contacts in parallel, Maxwell's slip or "
        "Prandtl and Ishlinskii's: Krasnosel'skii and Pokrovskii 1989; Al-Bender, Lampaert and "
        "Swevers 2005, IEEE Trans. Autom. Control 50(11)"
    )
    meaning = "friction that builds up over a distance after a reversal (presliding)"
    parameters = tuple(
        Parameter(f"F_{n}", "N·m", f"friction that builds up over {m:g} w")
        for n, m in enumerate(MULTIPLES, start=1)
    )
    shapes = (
        Shape("w", "rad", "deflection at which the first contact slides", 2e-4, 4e-3, 1e-3, 4),
    )
    coordinate = "since_reversal"
    shows_as = "loops over position after each reversal"
    look_alikes = {
        "stribeck": "hysteresis comes after a reversal only: creep without reversing",
        "coulomb": "hysteresis turns over within a distance after the reversal, Coulomb's at once",
    }
    motion = "reversals"
    next_motion = "reverse with strokes of 0.1 to 10 mrad, at two speeds"
    remembers = True

    def columns(self, x: Inputs, joint: int, shape: Values) -> Floats:
        settled = x.sign(joint)
        position, segment = np.ascontiguousarray(x.q[:, joint]), np.ascontiguousarray(x.segment)
        deflections = [stop(position, segment, settled, m * shape["w"]) for m in MULTIPLES]
        return np.stack([one - settled for one in deflections], axis=1)

    def reach(self, shape: Values) -> float:
        return MULTIPLES[-1] * shape["w"]

    def signs(self, x: Inputs, joint: int, shape: Values) -> Mapping[str, Floats]:
        """Return the sum: between two widths a third is made up for by either sign."""
        return {"all that builds up in N·m": np.ones(len(MULTIPLES))}
