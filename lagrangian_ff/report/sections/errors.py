"""How far the predicted torque is from the measured one, joint by joint."""

import math
from collections.abc import Mapping
from typing import Any

from lagrangian_ff.numbers import percent, typeset
from lagrangian_ff.report import html
from lagrangian_ff.report.page import Section

LEAD = (
    "The model predicted the torque of every sample from position, velocity and acceleration; the "
    "error is what the measured torque differs by."
)


def relative(error: Mapping[str, Any]) -> float:
    """Return the RMS error over the torque's spread; NaN if the torque did not vary."""
    nmse = error["nmse"]
    return math.sqrt(nmse) if nmse is not None and math.isfinite(nmse) else math.nan


def errors_section(record: Mapping[str, Any]) -> Section:
    """Return the best and the worst joint as cards, and a table of all, from a comparison."""
    joints: Mapping[str, Any] = record["joints"]
    judged = {name: relative(e) for name, e in joints.items() if math.isfinite(relative(e))}
    cards = []
    if judged:
        worst = max(judged, key=lambda name: judged[name])
        best = min(judged, key=lambda name: judged[name])
        cards = [
            _card(worst, judged[worst], joints[worst], "the worst joint"),
            _card(best, judged[best], joints[best], "the best joint"),
        ]
    outside = float(record["outside_range"])
    new = "outside the positions, speeds and accelerations it was identified on"
    cards.append(
        html.Card(percent(outside), "of the motion is new to the model", new, outside <= 0.05)
    )
    covered: Mapping[str, float] = record.get("covered", {})
    rows = []
    for name, error in joints.items():
        share = relative(error)
        spread = error["rmse"] / share if share > 0.0 else math.nan
        inside = [percent(covered[name])] if covered else []
        figures = [typeset(spread), typeset(error["rmse"]), percent(share)]
        rows.append([name, *figures, *inside, _word(share)])
    header = [
        "joint", "torque's spread [N·m]", "RMS error [N·m]", "error / spread",
        *(["inside its interval"] if covered else []), "in words",
    ]  # fmt: skip
    text = (
        "Spread is the standard deviation of the measured torque. An error of 100 % of it is what "
        "a constant would have; below 22 % (nmse 0.05) a model is good enough to drive with."
    )
    if covered:
        text += (
            " Inside its interval: the share of the measured torques that the model thought "
            "possible; it should be about 90 %."
        )
    body = html.cards(cards) + html.table(header, rows, strong=3) + html.note(text)
    return Section("How far is the model off?", LEAD, body)


def _card(joint: str, share: float, error: Mapping[str, Any], label: str) -> html.Card:
    return html.Card(
        percent(share),
        f"of the torque's spread is missed on {joint}, {label}",
        f"typically {typeset(error['rmse'])} N·m",
        share <= math.sqrt(0.05),
    )


def _word(share: float) -> str:
    if not math.isfinite(share):
        return "not judged: its torque did not vary"
    grades = ((0.01, "very good"), (0.05, "good"), (0.2, "fair"), (0.5, "poor"))
    return next((word for limit, word in grades if share**2 <= limit), "bad")
