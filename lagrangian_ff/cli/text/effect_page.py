"""The catalogue of effects in words: all of it in short, or one effect in full."""

from collections.abc import Mapping, Sequence
from typing import Any

from lagrangian_ff.cli.common.console import Console
from lagrangian_ff.cli.text.layout import number, table

HEADINGS = {
    "measurement": "measurement: faults of what was recorded, to be looked for first",
    "friction": "friction",
    "transmission": "transmission: motors, gears, joints that share a shaft",
    "mechanics": "mechanics: what a model of the links may lack",
    "event": "event: something that happened during the recording",
}
NAMES_WIDTH = 22


def say_catalogue(effects: Sequence[Mapping[str, Any]], console: Console) -> None:
    """Every effect with what it is and its formula, grouped by what causes it."""
    for kind, heading in HEADINGS.items():
        console.say(heading)
        for effect in effects:
            if effect["kind"] == kind:
                name = effect["name"].ljust(NAMES_WIDTH - 2)
                console.paragraph(f"  {name}{effect['meaning']}", "", " " * NAMES_WIDTH)
                console.paragraph(effect["formula"], " " * NAMES_WIDTH)
        console.say()


def say_effect(effect: Mapping[str, Any], explanation: str, console: Console) -> None:
    """One effect: formula, numbers, what it looks like, and what it is taken for.

    Args:
        effect: its record.
        explanation: paragraphs on the physics, empty lines between them.
        console: where to.
    """
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
        console.say(_shapes(effect["shapes"]))
    console.say(["", "how it shows"])
    if effect["shows_as"]:
        console.paragraph(f"{effect['shows_as']}; look over: {_words(effect['coordinate'])}", "  ")
    console.paragraph(f"motion that shows it: {effect['next_motion']}", "  ", "    ")
    if effect["look_alikes"]:
        console.say(["", f"what it is taken for, and how {effect['name']} is told from it"])
        for other, difference in effect["look_alikes"].items():
            name = other.ljust(NAMES_WIDTH - 2)
            console.paragraph(f"  {name}{difference}", "", " " * NAMES_WIDTH)
    if effect["caution"]:
        console.say()
        console.note(f"{effect['name']}: {effect['caution']}", "")


def _shapes(shapes: Sequence[Mapping[str, Any]]) -> list[str]:
    rows = [
        [s["name"], s["unit"], *(_bound(s, s[end]) for end in ("low", "high")), s["meaning"]]
        for s in shapes
    ]
    return table(["", "unit", "from", "to", "meaning"], rows)


def _bound(shape: Mapping[str, Any], value: float) -> str:
    return str(round(value)) if shape["whole"] else number(value)


def _words(coordinate: str) -> str:
    return coordinate.replace("since_reversal", "time since the joint turned round").replace(
        "order", "order spectrum over position"
    )
