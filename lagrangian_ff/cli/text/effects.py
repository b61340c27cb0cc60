"""Effects in words: the catalogue, one in full, and those of a model with their numbers."""

import re
from collections.abc import Mapping, Sequence
from typing import Any

from lagrangian_ff.cli.common.console import Console, table
from lagrangian_ff.numbers import number

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
NAMES_WIDTH = 22


def say_catalogue(effects: Sequence[Mapping[str, Any]], console: Console) -> None:
    """Print every effect with its meaning and its formula, grouped by what causes it."""
    for kind, heading in HEADINGS.items():
        console.say(heading)
        for effect in effects:
            if effect["kind"] == kind:
                name = effect["name"].ljust(NAMES_WIDTH - 2)
                console.paragraph(f"  {name}{effect['meaning']}", "", " " * NAMES_WIDTH)
                console.paragraph(effect["formula"], " " * NAMES_WIDTH)
        console.say()


def say_effect(effect: Mapping[str, Any], explanation: str, console: Console) -> None:
    """Print the record of one effect; `explanation` has paragraphs with empty lines between."""
    console.paragraph(f"{effect['name']}: {effect['meaning']}".rstrip(": "))
    console.say(["", f"  torque  {effect['formula']}", ""])
    for paragraph in explanation.split("\n\n"):
        if paragraph.strip():
            console.paragraph(" ".join(paragraph.split()), "  ")
            console.say()
    console.paragraph(f"source: {effect['source']}", "  ", "    ")
    console.say(["", "parameters, which are estimated"])
    rows = [[p["name"], p["unit"], p["meaning"]] for p in effect["parameters"]]
    console.say(table(["", "unit", "meaning"], rows))
    if effect["shapes"]:
        console.say(["", "numbers the torque is not linear in, which are searched"])
        rows = []
        for s in effect["shapes"]:
            ends = [str(round(s[e])) if s["whole"] else number(s[e]) for e in ("low", "high")]
            rows.append([s["name"], s["unit"], *ends, s["meaning"]])
        console.say(table(["", "unit", "from", "to", "meaning"], rows))
    console.say(["", "how it shows"])
    if effect["shows_as"]:
        over = COORDINATES.get(effect["coordinate"], effect["coordinate"])
        console.paragraph(f"{effect['shows_as']}; look over: {over}", "  ")
    console.paragraph(f"motion that shows it: {effect['next_motion']}", "  ", "    ")
    if effect["look_alikes"]:
        console.say(["", f"what it is taken for, and how {effect['name']} differs from it"])
        for other, difference in effect["look_alikes"].items():
            name = other.ljust(NAMES_WIDTH - 2)
            console.paragraph(f"  {name}{difference}", "", " " * NAMES_WIDTH)
    if effect["caution"]:
        console.say()
        console.note(f"{effect['name']}: {effect['caution']}")


def say_equations(
    heading: str, effects: Sequence[Mapping[str, Any]], console: Console, whose: str = "its"
) -> None:
    """Print the torque of effects as equations, and their parameters."""
    console.say(["", f"{heading} in N·m with qd in rad/s"])
    console.say(equations(effects))
    console.say(["", f"{whose} parameters with 90 % intervals"])
    console.say(parameter_table(effects))


def equations(effects: Sequence[Mapping[str, Any]]) -> list[str]:
    """Return one line a joint: the torque of all its effects, in N·m with qd in rad/s."""
    sums: dict[str, str] = {}
    for entry in effects:
        values = {name: number(p["value"]) for name, p in entry["parameters"].items()}
        term = _filled(entry["formula"], {**values, **entry.get("shape_words", {})})
        before = sums.get(entry["joint"])
        joined = f"{before} - {term[1:]}" if term.startswith("-") else f"{before} + {term}"
        sums[entry["joint"]] = term if before is None else joined
    width = max(map(len, sums), default=0)
    return [f"  {joint.ljust(width)}  τ = {text}" for joint, text in sums.items()]


def parameter_table(effects: Sequence[Mapping[str, Any]]) -> list[str]:
    """Return every parameter with unit, 90 % interval and a remark."""
    rows = []
    joint = None
    for entry in effects:
        for name, found in entry["parameters"].items():
            shown = "" if entry["joint"] == joint else entry["joint"]
            values = [number(found[key]) for key in ("value", "low", "high")]
            mark = remark(entry["effect"], found)
            rows.append([shown, entry["effect"], name, *values, found["unit"], mark])
            joint = entry["joint"]
    header = ["joint", "effect", "", "value", "5 %", "95 %", "unit", ""]
    return table(header, rows) if rows else []


def remark(effect: str, found: Mapping[str, Any]) -> str:
    """Return what the interval of a parameter means."""
    if found["low"] <= 0.0 <= found["high"]:
        return "may be 0"
    if found["high"] < 0.0 and _plain(effect):
        return "negative: alone no friction"
    return ""


def negative_friction(effects: Sequence[Mapping[str, Any]]) -> tuple[list[str], list[str]]:
    """Return the joints with friction that is surely negative.

    Returns:
        The joints on which all friction is negative, so that it would drive the motion; and
        those on which a part is, as when the kernel has taken some of it over.
    """
    found: dict[str, list[Mapping[str, Any]]] = {}
    for entry in effects:
        if _plain(entry["effect"]):
            found.setdefault(entry["joint"], []).extend(entry["parameters"].values())
    sure = {joint: ps for joint, ps in found.items() if any(p["high"] < 0.0 for p in ps)}
    whole = [joint for joint, ps in sure.items() if all(p["value"] < 0.0 for p in ps)]
    return whole, [joint for joint in sure if joint not in whole]


def _plain(effect: str) -> bool:
    """Return whether an effect is plain friction, which takes energy out if it is positive."""
    from lagrangian_ff.effects import EFFECTS

    return effect in EFFECTS and EFFECTS[effect].plain


def _filled(formula: str, values: Mapping[str, str]) -> str:
    filled = re.sub(r"[A-Za-z_]\w*", lambda name: values.get(name[0], name[0]), formula)
    return filled.replace("+ -", "- ")
