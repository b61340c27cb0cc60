"""Effects as equations with their numbers, and their parameters with intervals."""

import re
from collections.abc import Mapping, Sequence
from typing import Any

from lagrangian_ff.cli.text.layout import number, table

FRICTION = ("viscous", "coulomb")
"""Effects that take energy out, as their parameters are positive then."""


def equations(effects: Sequence[Mapping[str, Any]]) -> list[str]:
    """One line a joint: the torque of all its effects, in N·m with qd in rad/s."""
    sums: dict[str, str] = {}
    for entry in effects:
        values = {name: number(p["value"]) for name, p in entry["parameters"].items()}
        term = _filled(entry["formula"], {**values, **entry.get("shape_words", {})})
        before = sums.get(entry["joint"])
        if before is None:
            sums[entry["joint"]] = term
        elif term.startswith("-"):
            sums[entry["joint"]] = f"{before} - {term[1:]}"
        else:
            sums[entry["joint"]] = f"{before} + {term}"
    width = max(map(len, sums), default=0)
    return [f"  {joint.ljust(width)}  τ = {text}" for joint, text in sums.items()]


def parameter_table(effects: Sequence[Mapping[str, Any]]) -> list[str]:
    """Every parameter with unit and 90 % interval, and what is to be said of it."""
    rows = []
    joint = None
    for entry in effects:
        for name, found in entry["parameters"].items():
            rows.append(
                [
                    "" if entry["joint"] == joint else entry["joint"],
                    entry["effect"],
                    name,
                    number(found["value"]),
                    number(found["low"]),
                    number(found["high"]),
                    found["unit"],
                    remark(entry["effect"], found),
                ]
            )
            joint = entry["joint"]
    header = ["joint", "effect", "", "value", "5 %", "95 %", "unit", ""]
    return table(header, rows) if rows else []


def remark(effect: str, found: Mapping[str, Any]) -> str:
    """What the interval of a parameter says."""
    if found["low"] <= 0.0 <= found["high"]:
        return "may be 0"
    if found["high"] < 0.0 and effect in FRICTION:
        return "negative: alone no friction"
    return ""


def negative_friction(effects: Sequence[Mapping[str, Any]]) -> tuple[list[str], list[str]]:
    """Joints with friction that is surely negative.

    Returns:
        The joints on which all friction is negative, so that it would drive the motion; and
        those on which a part is, as when the kernel has taken some of it over.
    """
    found: dict[str, list[Mapping[str, Any]]] = {}
    for entry in effects:
        if entry["effect"] in FRICTION:
            found.setdefault(entry["joint"], []).extend(entry["parameters"].values())
    sure = {joint: ps for joint, ps in found.items() if any(p["high"] < 0.0 for p in ps)}
    whole = [joint for joint, ps in sure.items() if all(p["value"] < 0.0 for p in ps)]
    return whole, [joint for joint in sure if joint not in whole]


def _filled(formula: str, values: Mapping[str, str]) -> str:
    def value(match: "re.Match[str]") -> str:
        name = match.group()
        return values.get(name, name)

    return re.sub(r"[A-Za-z_]\w*", value, formula).replace("+ -", "- ")
