"""How far the predicted torque is from the measured one, joint by joint."""

import math
from typing import TYPE_CHECKING

from lagrangian_ff.numbers import percent, typeset
from lagrangian_ff.report import html
from lagrangian_ff.report.page import Section
from lagrangian_ff.words import grade

if TYPE_CHECKING:
    from lagrangian_ff.diagnosis.where import Localisation
    from lagrangian_ff.identification import Score

LEAD = (
    "The model predicted the torque of every sample from position, velocity and acceleration; the "
    "error is what the measured torque differs by."
)


def relative(score: "Score") -> dict[str, float]:
    """Return by joint the RMS error over the torque's spread, of joints whose torque varied."""
    nmse = zip(score.joints, score.nmse, strict=True)
    return {name: math.sqrt(one) for name, one in nmse if math.isfinite(one)}


def errors_section(where: "Localisation") -> Section:
    """Return the best and the worst joint as cards, and a table of all."""
    score, interval = where.comparison.score, where.comparison.interval
    rmse, judged = score.by_joint, relative(score)
    order = sorted(judged, key=lambda name: judged[name])
    ends = [(order[-1], "the worst joint"), (order[0], "the best joint")] if order else []
    cards = [
        html.Card(
            percent(judged[joint]),
            f"of the torque's spread is missed on {joint}, {label}",
            f"typically {typeset(rmse[joint])} N·m",
            judged[joint] <= math.sqrt(0.05),
        )
        for joint, label in ends
    ]
    new = "outside the positions, speeds and accelerations it was identified on"
    outside = where.comparison.outside
    cards.append(
        html.Card(percent(outside), "of the motion is new to the model", new, outside <= 0.05)
    )
    rows = []
    for n, name in enumerate(score.joints):
        share = judged.get(name, math.nan)
        spread = rmse[name] / share if share > 0.0 else math.nan
        inside = [percent(interval.covered[n])] if interval else []
        figures = [typeset(spread), typeset(rmse[name]), percent(share)]
        rows.append([name, *figures, *inside, grade(score.nmse[n])])
    header = ["joint", "torque's spread [N·m]", "RMS error [N·m]", "error / spread"]
    header += ["inside its interval", "in words"] if interval else ["in words"]
    text = (
        "Spread is the standard deviation of the measured torque. An error of 100 % of it is what "
        "a constant would have; below 22 % (nmse 0.05) a model is good enough to drive with."
    )
    if interval:
        text += (
            " Inside its interval: the share of the measured torques that the model thought "
            "possible; it should be about 90 %."
        )
    body = html.cards(cards) + html.table(header, rows, strong=3) + html.note(text)
    return Section("How far is the model off?", LEAD, body)
