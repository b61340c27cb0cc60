"""A curve as an effect: splines over one or two coordinates, for a torque that no formula fits.

A curve is Σ s_k B_k, with cubic B-splines B_k of the coordinate, or products of two of them. The
heights s = T b are those of its free directions, the columns of T, which `choosing.smoothness`
finds; the parameters b are solved for with all others. Outside what was seen the curve is zero: a
B-spline without a sample has no height, and beyond the ends the curve fades.
"""

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import product
from typing import Any, ClassVar

import numpy as np

from lagrangian_ff.arrays import Flags, Floats, Ints
from lagrangian_ff.effects.base import Effect, Parameter, Values
from lagrangian_ff.effects.inputs import Inputs
from lagrangian_ff.errors import EffectError

NAME = "curve"
FRICTION = "friction"
FADES = 0.1
"""Share of the range seen within which a curve fades to zero beyond an end."""
MOST = 4000
"""B-splines of a curve, at most, and directions of it."""

Reader = Callable[[Inputs, int], Floats]
KINDS: Mapping[str, tuple[str, str, str, Reader]] = {
    "position": ("q", "rad", "position", lambda x, joint: x.q[:, joint]),
    "velocity": ("qd", "rad/s", "velocity", lambda x, joint: x.qd[:, joint]),
    "acceleration": ("qdd", "rad/s²", "acceleration", lambda x, joint: x.qdd[:, joint]),
    "load": ("load", "N·m", "load", lambda x, joint: x.load[:, joint]),
    "reversal": ("since", "s", "time since reversal", Inputs.since_reversal),
}
"""By name what a curve may be over: symbol, unit, words, and what reads it."""


@dataclass(frozen=True)
class Over:
    """A coordinate that a curve is over.

    Attributes:
        kind: of `KINDS`.
        joint: the joint, from 0, that it is read of; None is the curve's own.
        name: of that joint, for people.
    """

    kind: str
    joint: int | None = None
    name: str = ""

    @classmethod
    def of(cls, text: str, joints: Sequence[str]) -> "Over":
        """Return the coordinate of a text such as `velocity` or `position@joint_2`.

        Raises:
            EffectError: there is no such coordinate or joint.
        """
        kind, at, joint = text.strip().partition("@")
        if kind not in KINDS:
            raise EffectError(
                f"a curve cannot be over '{text}'; expected one or two of {', '.join(KINDS)}, each "
                "of the joint itself or of another, as in position@joint_2"
            )
        if at and joint not in joints:
            raise EffectError(f"'{text}': the model has the joints {', '.join(joints)}")
        return cls(kind, joints.index(joint), joint) if at else cls(kind)

    def text(self) -> str:
        """Return it as `of` takes it."""
        return f"{self.kind}@{self.name}" if self.joint is not None else self.kind

    def read(self, x: Inputs, joint: int) -> Floats:
        """Return the coordinate (M,) of the inputs, for a curve on a joint."""
        return np.asarray(KINDS[self.kind][3](x, joint if self.joint is None else self.joint))

    @property
    def word(self) -> str:
        """Return the coordinate as a part of the effect's name; other joints count from 1."""
        return self.kind if self.joint is None else f"{self.kind}{self.joint + 1}"

    @property
    def symbol(self) -> str:
        """Return the coordinate as formulas have it."""
        symbol = KINDS[self.kind][0]
        return symbol if self.joint is None else f"{symbol}[{self.name or self.joint + 1}]"

    @property
    def unit(self) -> str:
        """Return its unit."""
        return KINDS[self.kind][1]

    @property
    def words(self) -> str:
        """Return it for people."""
        words = KINDS[self.kind][2]
        return words if self.joint is None else f"{words} of {self.name or self.joint + 1}"


@dataclass(frozen=True)
class Axis:
    """The cubic B-splines over one coordinate.

    Attributes:
        bends: (K,) increasing, K >= 2, where pieces meet; from the lowest to the highest seen.
    """

    bends: tuple[float, ...]

    @property
    def count(self) -> int:
        """Return the number of B-splines."""
        return len(self.bends) + 2

    @cached_property
    def knots(self) -> Floats:
        """Return (K + 6,) the knots: the bends, and three beyond each end."""
        bends, beyond = np.asarray(self.bends), np.arange(1.0, 4.0)
        below = bends[0] - beyond[::-1] * (bends[1] - bends[0])
        return np.concatenate([below, bends, bends[-1] + beyond * (bends[-1] - bends[-2])])

    def weights(self, at: Floats) -> tuple[Ints, Floats]:
        """Return the first (M,) of the four B-splines at each place (M,), and their values (M, 4).

        They add up to 1. Places outside count as the nearest end (de Boor 1972, J. Approx. Theory
        6(1), eq. (9)).
        """
        knots, last = self.knots, len(self.bends) - 2
        at = np.clip(at, self.bends[0], self.bends[-1])
        first = np.clip(np.searchsorted(self.bends, at, side="right") - 1, 0, last)
        left = [at - knots[first + 3 - n] for n in range(3)]
        right = [knots[first + 4 + n] - at for n in range(3)]
        values = [np.ones_like(at)]
        for degree in range(1, 4):
            carried, higher = np.zeros_like(at), []
            for n in range(degree):
                share = values[n] / (right[n] + left[degree - 1 - n])
                higher.append(carried + right[n] * share)
                carried = left[degree - 1 - n] * share
            values = [*higher, carried]
        return first, np.stack(values, axis=1)

    def fade(self, at: Floats) -> Floats:
        """Return (M,) 1 between the ends, falling smoothly to 0 within `FADES` beyond them."""
        low, high = self.bends[0], self.bends[-1]
        away = np.maximum(np.maximum(low - at, at - high), 0.0) / (FADES * (high - low))
        share = np.clip(1.0 - away, 0.0, 1.0)
        return np.asarray(share * share * (3.0 - 2.0 * share))


class Curve(Effect):
    """Whatever shape the data have, over one or two coordinates.

    Attributes:
        over: the coordinates.
        friction: whether it changes sign with the direction of motion.
        odd: whether f(-x) = -f(x) in the first coordinate.
        monotone: whether it only rises or only falls; its parameters are then at least 0.
        axes: of the coordinates; empty before it is made for a model.
        seen: (K,) which B-splines a sample was in.
        heights: (K, P) T, the B-splines' heights for each parameter.
    """

    source = "splines whose smoothness the evidence chooses"
    next_motion = "move through the whole range of what the curve is over"
    over: ClassVar[tuple[Over, ...]]
    friction: ClassVar[bool]
    odd: ClassVar[bool]
    monotone: ClassVar[bool]
    axes: ClassVar[tuple[Axis, ...]]
    seen: ClassVar[Flags]
    heights: ClassVar[Floats]

    def __reduce__(self) -> tuple[Any, ...]:
        content = self.over, self.friction, self.odd, self.monotone
        return _curve, (*content, self.axes, self.seen, self.heights)

    def stored(self) -> dict[str, Any]:
        """Return the curve as JSON holds it."""
        return {
            "over": [one.word for one in self.over],
            **{name: getattr(self, name) for name in ("friction", "odd", "monotone")},
            "bends": [list(axis.bends) for axis in self.axes],
            "seen": self.seen.astype(int).tolist(),
            "heights": self.heights.tolist(),
        }

    def made(self, axes: tuple[Axis, ...], seen: Flags, heights: Floats) -> "Curve":
        """Return the curve with these B-splines and heights; see the attributes."""
        return _curve(self.over, self.friction, self.odd, self.monotone, axes, seen, heights)

    def columns(self, x: Inputs, joint: int, shape: Values) -> Floats:
        at, fade = self._at(x, joint)
        out = self._values(at) * fade[:, None]
        return out * x.sign(joint)[:, None] if self.friction else out

    def outside(self, x: Inputs, joint: int) -> Flags:
        """Return (M,) where the coordinates lie outside what was seen, and the curve fades."""
        at, fade = self._at(x, joint)
        known = sum((weight * self.seen[row] for weight, row in self._splines(at)), 0.0 * fade)
        return np.asarray(fade * known < 1.0 - 1e-9)

    def whole(self) -> "Curve":
        """Return the curve with every height that it could have as a parameter."""
        return self.made(self.axes, self.seen, np.eye(len(self.seen))[:, self.seen])

    def along(self, count: int = 50) -> tuple[list[Floats], Floats]:
        """Return places along each coordinate, (count,), and the directions there.

        Returns:
            The places, and (count, P) or (count², P) of the P directions, without any sign of the
            velocity; over two coordinates the second runs fastest.
        """
        along = [np.linspace(axis.bends[0], axis.bends[-1], count) for axis in self.axes]
        at = [each.ravel() for each in np.meshgrid(*along, indexing="ij")]
        return along, self._values(at)

    def table(self, b: Floats, count: int = 50) -> tuple[list[Floats], Floats]:
        """Return places along each coordinate, (count,), and the torque there for parameters b.

        Returns:
            The places, and N·m, (count,) or (count, count), without the sign of the direction.
        """
        along, values = self.along(count)
        return along, (values @ b).reshape([count] * len(along))

    def words(self, b: Floats) -> str:
        """Return in words where it was seen, and how large it is, for parameters b (P,)."""
        along, torque = self.table(b)
        ranges = [
            f"{one.words} from {axis[0]:.3g} to {axis[-1]:.3g} {one.unit}"
            for one, axis in zip(self.over, along, strict=True)
        ]
        sign = ", times the sign of the velocity" if self.friction else ""
        return (
            f"f is between {torque.min():.3g} and {torque.max():.3g} N·m{sign}; seen for "
            f"{' and '.join(ranges)}, beyond which it fades to zero; {len(b)} free directions"
        )

    def _at(self, x: Inputs, joint: int) -> tuple[list[Floats], Floats]:
        """Return the coordinates, (M,) each, and (M,) how far the curve has not faded."""
        at = [one.read(x, joint) for one in self.over]
        fade = np.ones(len(x))
        for axis, values in zip(self.axes, at, strict=True):
            fade *= axis.fade(values)
        return at, fade

    def _values(self, at: Sequence[Floats]) -> Floats:
        """Return the directions (M, P) at some places, (M,) of each coordinate."""
        out = np.zeros((len(at[0]), self.heights.shape[1]))
        for weight, row in self._splines(at):
            out += weight[:, None] * self.heights[row]
        return out

    def _splines(self, at: Sequence[Floats]) -> list[tuple[Floats, Ints]]:
        """Return each of the 4 or 16 B-splines at every place: values (M,) and numbers (M,)."""
        every = [axis.weights(values) for axis, values in zip(self.axes, at, strict=True)]
        found = []
        for steps in product(range(4), repeat=len(every)):
            weight, row = np.ones(len(at[0])), np.zeros(len(at[0]), dtype=np.int64)
            for axis, step, (first, values) in zip(self.axes, steps, every, strict=True):
                weight = weight * values[:, step]
                row = row * axis.count + first + step
            found.append((weight, row))
        return found


def curve_over(
    over: Sequence[Over], *, friction: bool = False, odd: bool = False, monotone: bool = False
) -> Curve:
    """Return a curve that is not made yet: a wish, which `identification.extend` fulfils.

    Args:
        over, friction, odd, monotone: see `Curve`.

    Raises:
        EffectError: it is over none or more than two coordinates, over one twice, or monotone over
            two.
    """
    over = tuple(over)
    if not 1 <= len(over) <= 2 or len({(one.kind, one.joint) for one in over}) < len(over):
        raise EffectError(f"a curve is over one or two different coordinates, got {len(over)}")
    if monotone and len(over) > 1:
        raise EffectError("only a curve over one coordinate can be monotone")
    nothing = (), np.zeros(0, dtype=bool), np.zeros((0, 0))
    return _curve(over, friction, odd, monotone, *nothing)


def _curve(
    over: tuple[Over, ...],
    friction: bool,
    odd: bool,
    monotone: bool,
    axes: tuple[Axis, ...],
    seen: Flags,
    heights: Floats,
) -> Curve:
    kinds = {one.kind for one in over}
    words = " and ".join(one.words for one in over)
    brakes = friction or "velocity" in kinds or "reversal" in kinds
    formula = f"f({', '.join(one.symbol for one in over)})"
    directed = ", changing sign with direction" if friction else ""
    first = "since_reversal" if over[0].kind == "reversal" else over[0].kind
    content = {
        "name": "_".join([NAME, *[FRICTION] * friction, *(one.word for one in over)]),
        "formula": f"{formula} sign(qd)" if friction else formula,
        "meaning": f"a curve over {words}{directed}",
        "parameters": tuple(
            Parameter(f"c{n + 1}", "N·m", "a direction of the curve", positive=monotone)
            for n in range(heights.shape[1])
        ),
        "kind": "friction" if brakes else "mechanics",
        "part": "friction" if brakes else "inertia" if "acceleration" in kinds else "gravity",
        "coordinate": first,
        "shows_as": "whatever shape the data have",
        "remembers": "reversal" in kinds,
        "uses": frozenset({"load"} & kinds),
        "over": over, "friction": friction, "odd": odd, "monotone": monotone, "axes": axes,
        "seen": seen, "heights": heights,
    }  # fmt: skip
    made: Curve = type("Curve", (Curve,), content)()
    return made


def curve_named(name: str, joints: Sequence[str] = ()) -> Curve | None:
    """Return the curve of an effect's name, not made; None if it names no curve.

    Args:
        joints: names of all joints, for people.
    """
    first, *words = name.split("_")
    friction = words[:1] == [FRICTION]
    over = [_over(word, joints) for word in words[friction:]]
    known = [one for one in over if one is not None]
    if first != NAME or len(known) < len(over) or not 1 <= len(over) <= 2:
        return None
    return curve_over(known, friction=friction)


def _over(word: str, joints: Sequence[str]) -> Over | None:
    match = re.fullmatch(r"([a-z]+)([1-9]\d{0,3})?", word)
    if match is None or match[1] not in KINDS:
        return None
    if match[2] is None:
        return Over(match[1])
    joint = int(match[2]) - 1
    return Over(match[1], joint, joints[joint] if joint < len(joints) else f"joint {match[2]}")


def from_stored(record: Mapping[str, Any], joints: Sequence[str]) -> Curve:
    """Return a curve from its JSON.

    Raises:
        ValueError: it describes none.
    """
    over = [_over(str(word), joints) for word in record["over"]]
    axes = tuple(Axis(tuple(float(v) for v in bends)) for bends in record["bends"])
    seen = np.array(record["seen"], dtype=np.int64) > 0
    heights = np.array(record["heights"], dtype=np.float64)
    known = [one for one in over if one is not None]
    count = int(np.prod([axis.count for axis in axes])) if axes else 0
    increasing = all(
        len(a.bends) >= 2 and np.isfinite(a.bends).all() and (np.diff(a.bends) > 0.0).all()
        for a in axes
    )
    sound = heights.ndim == 2 and heights.shape[0] == count and seen.shape == (count,)
    if len(known) < len(over) or len(axes) != len(over) or not (increasing and sound):
        raise ValueError("a curve does not fit its B-splines")
    beyond = [one for one in known if one.joint is not None and joints and one.joint >= len(joints)]
    if beyond or max(heights.shape) > MOST or not np.isfinite(heights).all():
        raise ValueError("a curve has heights, or is over a joint, that cannot be")
    flags = {name: bool(record[name]) for name in ("friction", "odd", "monotone")}
    try:
        return curve_over(known, **flags).made(axes, seen, heights)
    except EffectError as error:
        raise ValueError(str(error)) from error
