"""Effects in words: the catalogue, one in full, and those of a model with their numbers."""

import re
from collections.abc import Collection, Mapping, Sequence
from typing import TYPE_CHECKING

from lagrangian_ff.cli.common.console import Console, table
from lagrangian_ff.numbers import number

if TYPE_CHECKING:
    from lagrangian_ff.effects import Effect
    from lagrangian_ff.identification.records import Estimate, FittedEffect

HEADINGS = {
    "measurement": "measurement: faults of what was recorded, to be looked for first",
    "friction": "friction",
    "transmission": "transmission: motors, gears, joints that share a shaft",
    "mechanics": "mechanics: what a model of the links may lack",
    "event": "event: something that happened during the recording",
}
COORDINATES = {
    "since_reversal": "time since the joint turned round",
    "order": "order spectrum over position",
}
"""Coordinates whose name is not clear by itself."""
NAMES_WIDTH = 24


def say_catalogue(effects: "Collection[Effect]", console: Console) -> None:
    """Print every effect with its meaning and its formula, grouped by what causes it."""
    from lagrangian_ff.effects import meaning_of

    for kind, heading in HEADINGS.items():
        console.say(heading)
        for effect in effects:
            if effect.kind == kind:
                _entry(effect.name, meaning_of(effect), console)
                console.paragraph(effect.formula, " " * NAMES_WIDTH)
        console.say()


def say_effect(effect: "Effect", console: Console) -> None:
    """Print all that an effect says about itself; its docstring is the explanation."""
    from lagrangian_ff.effects import look_alikes, meaning_of

    console.paragraph(f"{effect.name}: {meaning_of(effect)}".rstrip(": "))
    console.say(["", f"  torque  {effect.formula}", ""])
    for paragraph in (type(effect).__doc__ or "").split("\n\n"):
        if paragraph.strip():
            console.paragraph(" ".join(paragraph.split()), "  ")
            console.say()
    console.paragraph(f"source: {effect.source}", "  ", "    ")
    console.say(["", "parameters, which are estimated"])
    rows = [
        [p.name, p.unit, f"{p.meaning}; above zero" if p.positive else p.meaning]
        for p in effect.parameters
    ]
    console.say(table(["", "unit", "meaning"], rows))
    if effect.shapes:
        console.say(["", "numbers the torque is not linear in, which are searched"])
        rows = []
        for s in effect.shapes:
            ends = [str(round(end)) if s.whole else number(end) for end in (s.low, s.high)]
            rows.append([s.name, s.unit, *ends, s.meaning])
        console.say(table(["", "unit", "from", "to", "meaning"], rows))
    console.say(["", "how it shows"])
    if effect.shows_as:
        over = COORDINATES.get(effect.coordinate, effect.coordinate)
        console.paragraph(f"{effect.shows_as}; look over: {over}", "  ")
    console.paragraph(f"motion that shows it: {effect.next_motion}", "  ", "    ")
    if others := look_alikes(effect):
        console.say(["", f"what it is taken for, and how {effect.name} differs from it"])
        for other, difference in others.items():
            _entry(other, difference, console)
    if effect.caution:
        console.say()
        console.note(f"{effect.name}: {effect.caution}")


def _entry(name: str, text: str, console: Console) -> None:
    console.paragraph(f"  {name.ljust(NAMES_WIDTH - 2)}{text}", "", " " * NAMES_WIDTH)


def say_equations(
    heading: str, effects: "Sequence[FittedEffect]", console: Console, whose: str = "its"
) -> None:
    """Print the torque of effects as equations, and their parameters."""
    console.say(["", f"{heading} in N·m with qd in rad/s"])
    console.say(equations(effects))
    rows = parameter_table(effects)
    if rows:
        console.say(["", f"{whose} parameters with 90 % intervals"])
        console.say(rows)


def equations(effects: "Sequence[FittedEffect]") -> list[str]:
    """Return one line a joint: the torque of all its effects, in N·m with qd in rad/s."""
    sums: dict[str, str] = {}
    for one in effects:
        values = {name: number(p.value) for name, p in one.parameters.items()}
        term = _filled(one.formula, {**values, **one.shape_words})
        before = sums.get(one.joint)
        joined = f"{before} - {term[1:]}" if term.startswith("-") else f"{before} + {term}"
        sums[one.joint] = term if before is None else joined
    width = max(map(len, sums), default=0)
    return [f"  {joint.ljust(width)}  τ = {text}" for joint, text in sums.items()]


def parameter_table(effects: "Sequence[FittedEffect]") -> list[str]:
    """Return every parameter with unit, 90 % interval and a remark."""
    rows = []
    joint = None
    for one in effects:
        if is_curve(one.effect):  # many numbers that mean nothing one by one
            continue
        for name, found in one.parameters.items():
            shown = "" if one.joint == joint else one.joint
            values = map(number, (found.value, found.low, found.high))
            rows.append([shown, one.effect, name, *values, found.unit, remark(one.effect, found)])
            joint = one.joint
    header = ["joint", "effect", "", "value", "5 %", "95 %", "unit", ""]
    return table(header, rows) if rows else []


def is_curve(effect: str) -> bool:
    """Return whether an effect is a curve, by its name."""
    from lagrangian_ff.effects.curve import curve_named

    return curve_named(effect) is not None


def remark(effect: str, found: "Estimate") -> str:
    """Return what the interval of a parameter means."""
    if found.low <= 0.0 <= found.high:
        return "may be 0"
    return "negative: alone no friction" if found.high < 0.0 and _plain(effect) else ""


def negative_friction(effects: "Sequence[FittedEffect]") -> tuple[list[str], list[str]]:
    """Return the joints with friction that is surely negative.

    Returns:
        The joints on which all friction is negative, so that it would drive the motion; and
        those on which a part is, as when the kernel has taken some of it over.
    """
    found: dict[str, list[Estimate]] = {}
    for one in effects:
        if _plain(one.effect):
            found.setdefault(one.joint, []).extend(one.parameters.values())
    sure = {joint: ps for joint, ps in found.items() if any(p.high < 0.0 for p in ps)}
    whole = [joint for joint, ps in sure.items() if all(p.value < 0.0 for p in ps)]
    return whole, [joint for joint in sure if joint not in whole]


def _plain(effect: str) -> bool:
    """Return whether an effect is plain friction, which takes energy out if it is positive."""
    from lagrangian_ff.effects import EFFECTS

    return effect in EFFECTS and EFFECTS[effect].plain


def _filled(formula: str, values: Mapping[str, str]) -> str:
    filled = re.sub(r"[A-Za-z_]\w*", lambda name: values.get(name[0], name[0]), formula)
    return filled.replace("+ -", "- ")
