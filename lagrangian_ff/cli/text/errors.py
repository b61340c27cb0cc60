"""Errors of predicted torque: the table, and what the numbers mean."""

import math
from collections.abc import Mapping
from typing import Any

from lagrangian_ff.cli.text.layout import number, table

GRADES = ((0.01, "very good"), (0.05, "good"), (0.2, "fair"), (0.5, "poor"))
"""Up to which nmse each word holds; above the last it is `bad`."""

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


def grade(nmse: float | None) -> str:
    """An nmse in a word."""
    if nmse is None or not math.isfinite(nmse):
        return "not judged: its torque did not vary"
    return next((word for limit, word in GRADES if nmse <= limit), "bad")


def error_table(record: Mapping[str, Any]) -> list[str]:
    """The error of each joint and of all: record holds `joints`, `rmse`, `nmse`.

    Where the loss is robust, with the error that outliers do not move; see `medians`.
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
    """By joint what half of the torques held out are missed by less than, of a robust model."""
    joints = record.get("outliers", {}).get("joints", {})
    return {
        name: one["held_out_median"] for name, one in joints.items() if "held_out_median" in one
    }


def verdict(record: Mapping[str, Any]) -> str:
    """One sentence: is it good or bad, and where."""
    words: dict[str, list[str]] = {}
    for name, error in record["joints"].items():
        words.setdefault(grade(error["nmse"]), []).append(name)
    if len(words) == 1:
        return f"The model is {next(iter(words))} on every joint."
    order = [*(word for _, word in GRADES), "bad"]
    parts = [
        f"{word} on {', '.join(words[word])}"
        for word in sorted(words, key=lambda w: order.index(w) if w in order else len(order))
    ]
    return f"The model is {'; '.join(parts)}."


def covered(record: Mapping[str, Any]) -> str:
    """One sentence: which share of the measured torques lies inside the intervals."""
    shares = ", ".join(f"{share:.0%} of {name}" for name, share in record["covered"].items())
    return f"Of the measured torques, {shares} lie inside the model's 90 % intervals."


def worse_than(record: Mapping[str, Any], nmse: float) -> list[str]:
    """The joints whose nmse is above this."""
    return [
        name
        for name, error in record["joints"].items()
        if error["nmse"] is not None and math.isfinite(error["nmse"]) and error["nmse"] > nmse
    ]
