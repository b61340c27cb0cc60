"""Gears: the load that passes one, and one that is not stiff."""

from collections.abc import Sequence

import numpy as np

from lagrangian_ff.effects.base import Effect, Floats, Shape, Values
from lagrangian_ff.effects.inputs import Inputs
from lagrangian_ff.errors import EffectError

ROTOR = Shape(
    "Jr",
    "kg·m²",
    "inertia before the gear, which its load is free of",
    1e-6,
    1e3,
    1e-3,
    of_model=True,
)
"""Of the model: it corrects how much of the inertia the model counts into the load."""
SHARES = (0.0, 0.25, 0.5, 0.75)
"""Shares of a joint's inertia that are tried as the rotor's."""
LIKE = 0.05
"""Share of that inertia by which two values differ too little to try both."""
MATTERS = 0.25
"""Share of the load that the torque of that inertia must have to make a difference."""

OF = Shape("of", "1", "the joint whose gear it is", 0, 63, 0, whole=True, joint=True)
SHARE = (0.35, 2.5)
"""Of the load that may be behind a gear: one, but for what the model does not know of the load."""


def link_load(x: Inputs, joint: int, shape: Values) -> Floats:
    """Return (M,) N·m through the gear, without the inertia Jr of a shape or that of the model."""
    taken = float(x.rotor[joint])
    return np.asarray(x.load[:, joint] + (taken - shape.get("Jr", taken)) * x.qdd[:, joint])


def rotors(x: Inputs, joint: int) -> list[float]:
    """Return kg·m² to try for Jr, the model's own value first.

    The constant part of a joint's inertia may be the rotor's or the link's: no motion separates
    them. That matters only where it takes much of the torque, as on a vertical axis.
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


class Gear(Effect):
    """A gear between a motor, which the encoder reports, and a link that moves otherwise.

    The link of joint k moves relative to what is reported by M[k, k] d²(k)/dt² = load - carried. By
    the arm's inertia that also shakes the other joints, in the same course of time: joint j feels
    M[j, k] / M[k, k] of it. Hence the effect can be `of` another joint than the one whose torque it
    adds to.

    A recording hardly shows which part of the inertia is the rotor's, before the gear, and which
    the link's: the load may be off by a multiple of qdd, which a second parameter mends.
    """

    remembers = True
    uses = frozenset({"load"})

    def carried(self, load: Floats, part: Floats, step: float, shape: Values) -> Floats:
        """Return (M,) what the gear carries of a part of its load along an uninterrupted stretch.

        Args:
            load: (M,) N·m.  part: (M,) of it.  step: s between samples.  shape: of the effect.
        """
        raise NotImplementedError

    def columns(self, x: Inputs, joint: int, shape: Values) -> Floats:
        """Return the columns; raise EffectError if there is no such joint."""
        of = self.cause(joint, shape)
        if not 0 <= of < x.joints:
            raise EffectError(
                f"effect '{self.name}': there is no joint {of}; expected 0 to {x.joints - 1}"
            )
        # The same on every joint that feels it: kept, as all of them ask for it.
        key = (type(self), *sorted(shape.items()))
        if key not in x.kept:
            x.kept[key] = self._carried_beyond(x, of, shape)
        return x.kept[key]

    def _carried_beyond(self, x: Inputs, of: int, shape: Values) -> Floats:
        out = np.zeros((len(x), len(self.parameters)))
        for piece in x.pieces():
            step = x.step(piece)
            if step > 0.0:
                load, qdd = (np.ascontiguousarray(one[piece, of]) for one in (x.load, x.qdd))
                for n, part in enumerate((load, qdd)):
                    out[piece, n] = self.carried(load, part, step, shape) - part
        return out

    def cause(self, joint: int, shape: Values) -> int:
        return round(shape["of"])

    def possible(self, parameters: Floats) -> bool:
        """Refuse a small share: a gear gives way under all of its load, not a tenth of it."""
        return bool(SHARE[0] < parameters[0] < SHARE[1])

    def tried(self, load: Floats) -> Sequence[Values]:
        """Return the other shapes to try for a gear with a load (M,) N·m."""
        raise NotImplementedError

    def candidates(self, x: Inputs, joint: int) -> Sequence[Values]:
        """Return the shapes of the joint's own gear, then those of all others."""
        own_first = sorted(range(x.joints), key=lambda k: k != joint)
        return [{"of": float(k), **shape} for k in own_first for shape in self.tried(x.load[:, k])]
