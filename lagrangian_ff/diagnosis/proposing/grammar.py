"""The formulas that are proposed: a grammar of physical forms with dimensions that fit.

A formula is a head times a body: `sign(qd)` times `A*exp(-((q-c)/w)^2)`. Heads are what friction,
damping and load are in proportion to; bodies are functions of one coordinate, whose argument a
shape makes a pure number. The unit of a parameter follows from both.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from lagrangian_ff.arrays import Floats
from lagrangian_ff.effects import Inputs, Over
from lagrangian_ff.effects.formula import EVENLY, Formula, Range, formula_effect

NARROWEST, WIDEST = 0.03, 1.0
"""Widths that are searched, over the range of the coordinate."""
WIDTHS, CENTRES = 7, 24
HIGHEST, HIGHEST_OF_OTHERS = 40.0, 6.0
"""Periods in a turn that are searched, of the joint itself and of others."""
LEAST_TURN = 1.2
"""rad of an argument that a sine must go through, at the lowest number of periods."""
TURN = 1.0
"""rad by which neighbouring numbers of periods may differ at the ends of the motion."""
MOVES = 1e-3
"""rad, rad/s or N·m below which a coordinate stands still."""


@dataclass(frozen=True)
class Coordinate:
    """A coordinate of a motion, as formulas have it.

    Attributes:
        text: as in the formula.  unit: of it.  words: for people.
        kind: of `Over`, or `difference` for that of two positions.
        of: the kinds and joints that it is made of.
        values: (M,) along the motion.
    """

    text: str
    unit: str
    words: str
    kind: str
    of: tuple[Over, ...]
    values: Floats

    @property
    def own(self) -> bool:
        """Return whether it is the joint's own."""
        return all(one.joint is None for one in self.of)

    @property
    def low(self) -> float:
        """Return the lowest value seen."""
        return float(self.values.min())

    @property
    def width(self) -> float:
        """Return the range seen."""
        return float(np.ptp(self.values))

    @property
    def largest(self) -> float:
        """Return the largest magnitude seen."""
        return float(np.abs(self.values).max())


@dataclass(frozen=True)
class Head:
    """What a formula is in proportion to.

    Attributes:
        text: as in the formula; empty for nothing.  unit: of it; empty for none.
        words: for people.  kinds: what it depends on.
    """

    text: str
    unit: str
    words: str
    kinds: tuple[str, ...] = ()


HEADS = (
    Head("", "", "a torque"),
    Head("sign(qd)", "", "dry friction"),
    Head("qd", "rad/s", "viscous friction", ("velocity",)),
    Head("sign(qd)*abs(load)", "N·m", "friction in proportion to the load", ("load",)),
)


@dataclass(frozen=True)
class Body:
    """A function of one coordinate.

    Attributes:
        text: as in the formula, with parameters A and B.
        name: one word.  words: for people; may name shapes in braces.
        shapes: ranges by name.
        units: of the parameters, as powers of the coordinate that divide it; 0 is none.
        shape_units: by name.
    """

    text: str
    name: str
    words: str
    shapes: Mapping[str, Range] = field(default_factory=dict)
    powers: tuple[float, ...] = (0.0,)
    shape_units: Mapping[str, str] = field(default_factory=dict)


@dataclass(frozen=True)
class Form:
    """A formula of the grammar on one joint.

    Attributes:
        effect: the formula.  coordinate, head, body: what it is made of.
    """

    effect: Formula
    coordinate: Coordinate
    head: Head
    body: Body

    def words(self, shape: Mapping[str, float]) -> str:
        """Return what it might be, for shapes by name."""
        values = {name: f"{value:.3g}" for name, value in shape.items()}
        if "n" in shape:
            kind = "a wave" if shape["n"] < 1.0 else TOOTH
            values["every"] = f"{kind} every {360.0 / shape['n']:.3g}°"
        return _said(self.head, self.body, self.coordinate, values)


TOOTH = "a detent, a tooth or a wave"


def _said(head: Head, body: Body, u: Coordinate, values: Mapping[str, str]) -> str:
    """Return what a formula might be, for shapes by name, in words."""
    return f"{head.words} {body.words.format(u=u.words, unit=u.unit, **values)}"


def _widths(u: Coordinate, name: str, steps: int = WIDTHS) -> tuple[dict[str, Range], dict]:
    size = u.width if u.kind in ("position", "difference") else u.largest
    return {name: (NARROWEST * size, WIDEST * size, steps)}, {name: u.unit}


def _even(u: Coordinate) -> Iterator[Body]:
    """Yield functions of a magnitude: of a speed, a load, an acceleration, a time."""
    t, (scale, unit) = u.text, _widths(u, "s", 12)
    size = t if u.kind == "reversal" else f"abs({t})"
    how = "that {} with the " + u.words
    falls = how.format("falls") + " on a scale of {s} {unit}"
    yield Body(f"A*{size}^p", "power", how.format("grows as the power {p}"),
               {"p": (0.25, 4.0, 16)}, (np.nan,), {"p": "1"})  # fmt: skip
    yield Body(f"A*exp(-({t}/s)^2)", "bell", falls, scale, shape_units=unit)
    yield Body(f"A*exp(-{size}/s)", "decay", falls, scale, shape_units=unit)
    yield Body(f"A/(1+({t}/s)^2)", "hyperbola", falls, scale, shape_units=unit)
    saturates = how.format("levels off") + " beyond {s} {unit}"
    yield Body(f"A*tanh({size}/s)", "saturation", saturates, scale, shape_units=unit)
    slower = how.format("grows ever slower") + ", on a scale of {s} {unit}"
    yield Body(f"A*log(1+{size}/s)", "logarithm", slower, scale, shape_units=unit)


def _placed(u: Coordinate) -> Iterator[Body]:
    """Yield functions of a place."""
    t = u.text
    widths, unit = _widths(u, "w")
    centred = {"c": (u.low, u.low + u.width, CENTRES, EVENLY), **widths}
    units = {**unit, "c": u.unit}
    away = f"{t}-c"
    near = "near {u} = {c} {unit}, within {w}"
    yield Body(f"A*exp(-(({away})/w)^2)", "bump", f"that differs {near}: a damaged or tight place",
               centred, shape_units=units)  # fmt: skip
    yield Body(f"A*tanh(({away})/w)", "step", f"that steps {near}: something that is taken along "
               "or pinched", centred, shape_units=units)  # fmt: skip
    at = {"c": centred["c"]}
    yield Body(f"A*({away}+abs({away}))/2", "upper_stop", "that grows beyond {u} = {c} {unit}: "
               "something soft is touched", at, (1.0,), {"c": u.unit})  # fmt: skip
    yield Body(f"A*({away}-abs({away}))/2", "lower_stop", "that grows below {u} = {c} {unit}: "
               "something soft is touched", at, (1.0,), {"c": u.unit})  # fmt: skip
    stiffens = "that grows exponentially with {u}, by e in {w} {unit}: something that stiffens"
    falls = "that falls exponentially with {u}, by e in {w} {unit}: something that slackens"
    yield Body(f"A*exp({t}/w)", "growth", stiffens, widths, shape_units=unit)
    yield Body(f"A*exp(-{t}/w)", "fall", falls, widths, shape_units=unit)
    yield Body(f"A*{t}", "line", "in proportion to {u}", {}, (1.0,))
    yield Body(f"A*abs({t})", "corner", "in proportion to the size of {u}", {}, (1.0,))
    yield Body(f"A*{t}+B*{t}^2", "parabola", "that bends with {u}", {}, (1.0, 2.0))
    yield Body(f"A*{t}+B*{t}^3", "cubic", "that stiffens with {u}", {}, (1.0, 3.0))


def _waves(u: Coordinate) -> Iterator[Body]:
    """Yield waves over an angle."""
    lowest = max(0.3, LEAST_TURN / u.width)
    highest = HIGHEST if u.own else HIGHEST_OF_OTHERS
    if lowest >= highest:
        return
    ratio = 1.0 + TURN / (highest * u.width)
    steps = int(np.clip(np.log(highest / lowest) / np.log(ratio), 8, 300))
    words = "with {u}, {n} times a turn: {every}"
    yield Body(f"A*cos(n*{_inner(u)})+B*sin(n*{_inner(u)})", "wave", words,
               {"n": (lowest, highest, steps)}, (0.0, 0.0), {"n": "1"})  # fmt: skip


def _inner(u: Coordinate) -> str:
    return f"({u.text})" if len(u.of) > 1 else u.text


def bodies(u: Coordinate) -> Iterator[Body]:
    """Yield the functions of a coordinate."""
    if u.kind in ("position", "difference"):
        yield from _waves(u)
    if u.kind == "position":
        yield from _placed(u)
    if u.kind in EVEN and u.own:
        yield from _even(u)
    if u.kind == "velocity" and u.own:
        yield Body(
            "A*abs(qd)", "size", "in proportion to the speed, whichever the direction", {}, (1.0,)
        )
    if u.kind in ("load", "acceleration") and u.own:
        yield Body(
            f"A*{u.text}*abs({u.text})", "square", "that grows as the square of {u}", {}, (2.0,)
        )
    if u.kind in EVEN and not u.own:
        yield Body(f"A*{u.text}", "line", "in proportion to {u}", {}, (1.0,))
        yield Body(f"A*sign({u.text})", "step", "with the sign of {u}: a shaft that is shared")


def coordinates(
    x: Inputs, joint: int, joints: Sequence[str], over: Sequence[Over] = ()
) -> list[Coordinate]:
    """Return the coordinates that formulas on a joint may be of.

    Args:
        x: the motion.  joint: index.  joints: names of all.
        over: those that they may be of; all if empty.
    """
    allowed = {(one.kind, one.joint) for one in over}
    names = {"position": ("q", "rad"), "velocity": ("qd", "rad/s"),
             "acceleration": ("qdd", "rad/s²"), "load": ("load", "N·m"),
             "reversal": ("since", "s")}  # fmt: skip
    found = []
    for n in (None, *(n for n in range(x.joints) if n != joint)):
        for kind, (text, unit) in names.items():
            if n is not None and kind in ("load", "reversal"):
                continue
            one = Over(kind, n, "" if n is None else joints[n])
            label = text if n is None else f"{text}_{n + 1}"
            found.append(Coordinate(label, unit, one.words, kind, (one,), one.read(x, joint)))
    own = found[0]
    for other in [one for one in found if one.kind == "position" and not one.own]:
        for sign, words in (("-", "minus"), ("+", "plus")):
            both = own.values + (other.values if sign == "+" else -other.values)
            text, said = f"q{sign}{other.text}", f"position {words} that of {other.of[0].name}"
            of = (*own.of, *other.of)
            found.append(Coordinate(text, "rad", said, "difference", of, both))
    return [
        one
        for one in found
        if one.width > MOVES
        and (not allowed or {(part.kind, part.joint) for part in one.of} <= allowed)
    ]


def forms(x: Inputs, joint: int, joints: Sequence[str], over: Sequence[Over] = ()) -> list[Form]:
    """Return all formulas of the grammar on one joint; see `coordinates`."""
    found: dict[str, Form] = {}
    for u in coordinates(x, joint, joints, over):
        for head in HEADS:
            if u.kind in head.kinds and u.own:
                continue
            for body in bodies(u):
                form = _form(head, body, u, joint)
                if form is not None:
                    found.setdefault(form.effect.formula, form)
    return list(found.values())


def _form(head: Head, body: Body, u: Coordinate, joint: int) -> Form | None:
    """Return a formula; None if head and body do not go together."""
    even = u.kind in EVEN and u.own
    if even and not head.text and body.name not in ALONE:
        return None
    if not u.own and (head.kinds or (head.text and u.kind in EVEN)):
        return None  # what another joint does acts on friction as such, if at all
    text = f"{head.text}*({body.text})" if head.text else body.text
    names = [one for one in "ABC" if one in body.text]
    powers = dict(zip(names, body.powers, strict=True))
    units = {**body.shape_units, **{name: _unit(head, u, power) for name, power in powers.items()}}
    word = "_".join(["formula", *HEAD_WORDS[head.text], body.name, _word(u)])
    meaning = _said(head, body, u, {**{name: name for name in body.shapes}, "every": TOOTH})
    effect = formula_effect(word, text, body.shapes, meaning, units, joint)
    return Form(effect, u, head, body)


HEAD_WORDS = {"": (), "sign(qd)": ("friction",), "qd": ("viscous",),
              "sign(qd)*abs(load)": ("load",)}  # fmt: skip
EVEN = ("velocity", "acceleration", "load", "reversal")
"""Coordinates whose functions are even: what is in proportion to them changes its sign."""
ALONE = ("size", "square")
"""Even functions that are torques without a head."""


def _word(u: Coordinate) -> str:
    return "_".join(one.word for one in u.of) + ("_sum" if "+" in u.text else "")


def _unit(head: Head, u: Coordinate, power: float) -> str:
    """Return the unit of a parameter, N·m over what it multiplies."""
    below = [one for one in (head.unit,) if one]
    if np.isnan(power):
        below.append(f"({u.unit})^p")
    elif power:
        below.append(u.unit if power == 1.0 else f"({u.unit})^{power:g}")
    return (
        "1"
        if below == ["N·m"]
        else "/".join(["N·m", *(f"({b})" if "/" in b else b for b in below)])
    )
