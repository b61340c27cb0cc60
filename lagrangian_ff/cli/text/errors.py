"""The errors of a model in text: the table, its meaning, and the regions."""

import math
from collections.abc import Mapping
from typing import Any

from lagrangian_ff.cli.common.console import Console, table
from lagrangian_ff.numbers import number

GRADES = ((0.01, "very good"), (0.05, "good"), (0.2, "fair"), (0.5, "poor"))
"""The nmse up to which each word holds; above the last it is `bad`."""

LEGEND = (
    "rmse: typical error of the predicted torque. nmse: its square over the variance of the "
    "measured torque; 0 is perfect, 1 is no better than a constant. In words: "
    + ", ".join(f"{word} up to {limit:g}" for limit, word in GRADES)
    + ", bad above."
)

HALF_LEGEND = (
    "half below: half of the joint's torques are missed by less, whatever the outliers among them; "
    "rmse and nmse count those in full."
)

MOST = 12
"""Regions that are printed; the rest is in the record."""
NOWHERE = "nowhere in particular: the error is spread evenly over the motion"


def grade(nmse: float | None) -> str:
    """Return an nmse as a word."""
    if nmse is None or not math.isfinite(nmse):
        return "not judged: its torque did not vary"
    return next((word for limit, word in GRADES if nmse <= limit), "bad")


def error_table(record: Mapping[str, Any]) -> list[str]:
    """Return the error of each joint and of all, from `joints`, `rmse` and `nmse` of a record.

    A robust model has one more column, the error that outliers do not move; see `medians`.
    """
    half = medians(record)
    rows = [
        [name, number(error["rmse"]), *([number(half[name])] if half else []),
         number(error["nmse"]), grade(error["nmse"])]
        for name, error in record["joints"].items()
    ]  # fmt: skip
    blank = [""] if half else []
    rows.append(["all joints", number(record["rmse"]), *blank, number(record["nmse"]), ""])
    header = ["half below [N·m]"] if half else []
    return table(["joint", "rmse [N·m]", *header, "nmse", "in words"], rows)


def medians(record: Mapping[str, Any]) -> dict[str, float]:
    """Return by joint the median error of held-out torques; empty unless the loss is robust."""
    joints = record.get("outliers", {}).get("joints", {})
    return {
        name: one["held_out_median"] for name, one in joints.items() if "held_out_median" in one
    }


def verdict(record: Mapping[str, Any]) -> str:
    """Return in one sentence whether the model is good or bad, and on which joints."""
    words: dict[str, list[str]] = {}
    for name, error in record["joints"].items():
        words.setdefault(grade(error["nmse"]), []).append(name)
    if len(words) == 1:
        return f"The model is {next(iter(words))} on every joint."
    order = [*(word for _, word in GRADES), "bad", grade(None)]
    parts = [f"{word} on {', '.join(words[word])}" for word in sorted(words, key=order.index)]
    return f"The model is {'; '.join(parts)}."


def covered(record: Mapping[str, Any]) -> str:
    """Return in one sentence which share of the measured torques lies inside the intervals."""
    shares = ", ".join(f"{share:.0%} of {name}" for name, share in record["covered"].items())
    return f"Of the measured torques, {shares} lie inside the model's 90 % intervals."


def worse_than(record: Mapping[str, Any], nmse: float) -> list[str]:
    """Return the joints whose nmse is above this."""
    return [
        name
        for name, error in record["joints"].items()
        if error["nmse"] is not None and math.isfinite(error["nmse"]) and error["nmse"] > nmse
    ]


def say_errors(record: Mapping[str, Any], console: Console) -> None:
    """Print the errors of a comparison, what they mean, and whether they are good or bad."""
    console.say(error_table(record))
    console.paragraph(LEGEND, "  ")
    console.say()
    console.paragraph(verdict(record))


def say_where(record: Mapping[str, Any], console: Console) -> None:
    """Print the regions that hold most of the error of a comparison."""
    words = record["words"]
    if len(record["evenly"]) == len(record["joints"]) and len(words) == 1:
        words = [NOWHERE]
    console.say("where it fails")
    for text in words[:MOST]:
        console.paragraph(text, "  ", "    ")
    if len(words) > MOST:
        console.say(f"  and {len(words) - MOST} more places, see --report or --json")


def next_step(record: Mapping[str, Any]) -> list[str]:
    """Return the command that looks for what is missing."""
    sources = " ".join(map(str, record["sources"]))
    return [
        "next: which physical effect is missing?",
        f"  lagrangian_ff diagnose {record['model']} {sources}",
    ]
