"""The errors of a model in text: the table, its meaning, and the regions."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

from lagrangian_ff.cli.common.console import Console, table
from lagrangian_ff.numbers import number
from lagrangian_ff.words import GRADES, grade

if TYPE_CHECKING:
    from lagrangian_ff.diagnosis.compare import Interval
    from lagrangian_ff.diagnosis.where import Localisation
    from lagrangian_ff.identification import Score

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


def error_table(score: "Score", half: Mapping[str, float] | None = None) -> list[str]:
    """Return the error of each joint and of all; `half` is the median in N·m of robust models."""
    rows = [
        [name, number(rmse), *([number(half[name])] if half else []), number(nmse), grade(nmse)]
        for name, rmse, nmse in zip(score.joints, score.rmse, score.nmse, strict=True)
    ]
    blank = [""] if half else []
    rows.append(["all joints", number(score.total), *blank, number(score.mean_nmse), ""])
    header = ["half below [N·m]"] if half else []
    return table(["joint", "rmse [N·m]", *header, "nmse", "in words"], rows)


def verdict(score: "Score") -> str:
    """Return in one sentence whether the model is good or bad, and on which joints."""
    words: dict[str, list[str]] = {}
    for name, nmse in zip(score.joints, score.nmse, strict=True):
        words.setdefault(grade(nmse), []).append(name)
    if len(words) == 1:
        return f"The model is {next(iter(words))} on every joint."
    order = [*(word for _, word in GRADES), "bad", grade(None)]
    parts = [f"{word} on {', '.join(words[word])}" for word in sorted(words, key=order.index)]
    return f"The model is {'; '.join(parts)}."


def covered(interval: "Interval") -> str:
    """Return in one sentence which share of the measured torques lies inside the intervals."""
    found = zip(interval.joints, interval.covered, strict=True)
    shares = ", ".join(f"{share:.0%} of {name}" for name, share in found)
    return f"Of the measured torques, {shares} lie inside the model's 90 % intervals."


def worse_than(score: "Score", nmse: float) -> list[str]:
    """Return the joints whose nmse is above this, or that were not judged."""
    return [name for name, one in zip(score.joints, score.nmse, strict=True) if not one <= nmse]


def say_errors(score: "Score", console: Console) -> None:
    """Print the errors of a comparison, what they mean, and whether they are good or bad."""
    console.say(error_table(score))
    console.paragraph(LEGEND, "  ")
    console.say()
    console.paragraph(verdict(score))


def say_where(where: "Localisation", console: Console) -> None:
    """Print the regions that hold most of the error of a comparison."""
    words = where.words()
    if len(where.evenly) == len(where.comparison.score.joints) and len(words) == 1:
        words = [NOWHERE]
    console.say("where it fails")
    for text in words[:MOST]:
        console.paragraph(text, "  ", "    ")
    if len(words) > MOST:
        console.say(f"  and {len(words) - MOST} more places, see --report or --json")


def next_step(model: str, sources: Sequence[str]) -> list[str]:
    """Return the command that looks for what is missing."""
    return [
        "next: which physical effect is missing?",
        f"  lagrangian_ff diagnose {model} {' '.join(sources)}",
    ]
