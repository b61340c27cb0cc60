"""What a gear that is not stiff shares, whatever lets it give way."""

from collections.abc import Mapping, Sequence

import numpy as np

from lagrangian_ff.effects.base import Effect, Floats, Shape
from lagrangian_ff.effects.inputs import Inputs
from lagrangian_ff.errors import EffectError

OF = Shape("of", "1", "the joint whose gear it is", 0, 63, 0, whole=True, joint=True)

SHARE = (0.35, 2.5)
"""Of the load that may be behind a gear: one, but for what the model does not know of the load."""


class Gear(Effect):
    """A gear between a motor, which the encoder reports, and a link that moves otherwise.

    The link of joint k moves relative to what is reported by M[k, k] d²(k)/dt² = load - carried. By
    the arm's inertia that also shakes the other joints, in the same course of time: joint j feels
    M[j, k] / M[k, k] of it. Hence the effect can be `of` another joint than the one whose torque it
    adds to.

    A recording cannot tell well which part of the inertia is the rotor's, before the gear, and
    which the link's: the load may be off by a multiple of qdd, which a second parameter mends.
    """

    remembers = True
    uses = frozenset({"load"})

    def carried(
        self, load: Floats, part: Floats, step: float, shape: Mapping[str, float]
    ) -> Floats:
        """(M,) what the gear carries of a part of its load along an uninterrupted stretch.

        Args:
            load: (M,) N·m.  part: (M,) of it.  step: s between samples.  shape: of the effect.
        """
        raise NotImplementedError

    def columns(self, x: Inputs, joint: int, shape: Mapping[str, float]) -> Floats:
        """See `Effect.columns`.

        Raises:
            EffectError: there is no such joint.
        """
        of = self.cause(joint, shape)
        if not 0 <= of < x.joints:
            raise EffectError(
                f"effect '{self.name}': there is no joint {of}; expected 0 to {x.joints - 1}"
            )
        # The same on whichever joint it is felt: kept, as all of them are asked for.
        key = (type(self), *sorted(shape.items()))
        if key not in x.kept:
            x.kept[key] = self._carried_beyond(x, of, shape)
        return x.kept[key]

    def _carried_beyond(self, x: Inputs, of: int, shape: Mapping[str, float]) -> Floats:
        out = np.zeros((len(x), len(self.parameters)))
        for piece in x.pieces():
            step = x.step(piece)
            if step > 0.0:
                load, qdd = (np.ascontiguousarray(one[piece, of]) for one in (x.load, x.qdd))
                for n, part in enumerate((load, qdd)):
                    out[piece, n] = self.carried(load, part, step, shape) - part
        return out

    def cause(self, joint: int, shape: Mapping[str, float]) -> int:
        """See `Effect.cause`."""
        return round(shape["of"])

    def possible(self, parameters: Floats) -> bool:
        """See `Effect.possible`: a gear gives way under all of its load, not a tenth of it."""
        return bool(SHARE[0] < parameters[0] < SHARE[1])

    def tried(self, load: Floats) -> Sequence[Mapping[str, float]]:
        """The other shapes to try where the gear has a load (M,) N·m."""
        raise NotImplementedError

    def candidates(self, x: Inputs, joint: int) -> Sequence[Mapping[str, float]]:
        """The joint's own gear, then those of all others."""
        own_first = sorted(range(x.joints), key=lambda k: k != joint)
        return [{"of": float(k), **shape} for k in own_first for shape in self.tried(x.load[:, k])]
