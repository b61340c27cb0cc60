"""Products of what the joints do: smooth functions of up to three quantities at once.

Along each position a function is spanned by 1, sin and cos, which any narrow range bends to a
parabola and a whole turn to a wave; products of these over several joints, times a factor, are
functions of all of them.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from lagrangian_ff.arrays import Floats
from lagrangian_ff.effects import Inputs, Over
from lagrangian_ff.words import listed

WITH_SIGN = "changing sign with direction"

STILL = 1e-3
"""Range in rad below which a joint stands still."""
Part = tuple[str, int, tuple[int, ...]]
"""Factor, the joint it is read of, and the joints whose positions are multiplied with it."""


@dataclass(frozen=True)
class Product:
    """A torque that depends on the positions of some joints, times a factor.

    Attributes:
        factor: key of `FACTORS`.  other: the joint it is read of.
        positions: the joints.
        middle: (N, 2) of all joints, the angle about which sin and cos are taken, and the mean of
            that cos.
    """

    factor: str
    other: int
    positions: tuple[int, ...]
    middle: tuple[tuple[float, float], ...]

    @property
    def name(self) -> str:
        """Return the name, for records; joints are counted from 0."""
        return self.coordinate

    @property
    def coordinate(self) -> str:
        """Return the quantities in words, after "depends on"; joints are counted from 0."""
        several = "s" if len(self.positions) > 1 else ""
        where = f"the position{several} of {listed([f'joint {n}' for n in self.positions])}"
        words, sign = WORDS[self.factor]
        parts = [words.format(f"joint {self.other}")] if words else []
        parts += [where] if self.positions else []
        return f"{' and '.join(parts)}{sign}"

    @property
    def friction(self) -> bool:
        """Return whether it changes sign with the direction of motion."""
        return self.factor in ("sign", "load")

    def over(self, joint: int) -> tuple[Over, ...]:
        """Return the coordinates that it depends on, if a joint has it."""
        read = KINDS.get(self.factor)
        first = [(read, joint if read == "load" else self.other)] if read else []
        places = [*first, *(("position", n) for n in self.positions)]
        return tuple(Over(kind, None if n == joint else n) for kind, n in places)

    @property
    def parts(self) -> list[Part]:
        """Return the parts that it is the sum of: products over fewer positions too."""
        sizes = range(0 if self.factor else 1, len(self.positions) + 1)
        some = (positions for k in sizes for positions in combinations(self.positions, k))
        return [(self.factor, self.other, positions) for positions in some]

    def columns(self, x: Inputs, joint: int) -> Floats:
        """Return the products (S, K)."""
        waves = _waves(x, self.middle)
        return np.concatenate([_columns(x, joint, part, waves) for part in self.parts], axis=1)


Factor = Callable[[Inputs, int, int], Floats]
"""Returns (S,) of the inputs, for the joint whose torque it is and another."""


def _direction(x: Inputs, joint: int) -> Floats:
    return x.sign(joint) if x.whole is None else x.mean(x.whole.sign(joint))


FACTORS: Mapping[str, Factor] = {
    "": lambda x, joint, other: np.ones(len(x)),
    "sign": lambda x, joint, other: _direction(x, joint),
    "load": lambda x, joint, other: x.load[:, joint] * _direction(x, joint),
    "qd": lambda x, joint, other: x.qd[:, other],
    "qdd": lambda x, joint, other: x.qdd[:, other],
}
WORDS = {
    "": ("", ""),
    "sign": ("", f", {WITH_SIGN}"),
    "load": ("its load", f", {WITH_SIGN}"),
    "qd": ("the velocity of {}", ""),
    "qdd": ("the acceleration of {}", ""),
}
"""Words of a factor before and after the positions."""
KINDS = {"load": "load", "qd": "velocity", "qdd": "acceleration"}
"""Coordinates that factors are."""
DEEPEST = {"": 3, "sign": 3, "load": 1, "qd": 2, "qdd": 1}
"""Positions multiplied with a factor, at most."""


def products_of(x: Inputs, joint: int) -> Iterator[Product]:
    """Yield every product that a motion can show on a joint."""
    middle = 0.5 * (x.q.max(axis=0) + x.q.min(axis=0))
    level = np.cos(x.q - middle).mean(axis=0)
    about = tuple(zip(middle.tolist(), level.tolist(), strict=True))
    moving = np.flatnonzero(np.ptp(x.q, axis=0) > STILL).tolist()
    for factor, deepest in DEEPEST.items():
        for other in moving if factor in ("qd", "qdd") else [joint]:
            for count in range(0 if factor else 1, deepest + 1):
                for positions in combinations(moving, count):
                    yield Product(factor, other, positions, about)


def pool(x: Inputs, joint: int) -> tuple[Floats, dict[Part, slice]]:
    """Return the columns (S, K) of all products on a joint, each once, and each part's place."""
    columns: list[Floats] = []
    places: dict[Part, slice] = {}
    first = 0
    waves: list[Floats] = []
    for product in products_of(x, joint):
        waves = waves or _waves(x, product.middle)
        key = product.parts[-1]  # the product of all positions: the others came before
        columns.append(_columns(x, joint, key, waves))
        places[key] = slice(first, first + columns[-1].shape[1])
        first = places[key].stop
    return np.concatenate(columns or [np.zeros((len(x), 0))], axis=1), places


def _waves(x: Inputs, middle: Sequence[tuple[float, float]]) -> list[Floats]:
    """Return sin and cos (S, 2) of each position about its middle, the cos less its mean."""
    return [
        np.stack([np.sin(q - centre), np.cos(q - centre) - level], axis=1)
        for q, (centre, level) in zip(x.q.T, middle, strict=True)
    ]


def _columns(x: Inputs, joint: int, part: Part, waves: Sequence[Floats]) -> Floats:
    """Return the products (S, 2^P) of one part."""
    factor, other, positions = part
    out = FACTORS[factor](x, joint, other)[:, None]
    for n in positions:
        out = (out[:, :, None] * waves[n][:, None, :]).reshape(len(x), -1)
    return out
