"""What the lines of a study come to: errors by model and number of joints, and comparisons."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from lagrangian_ff.studies.common.case import Line
from lagrangian_ff.studies.common.findings import Finding, finding
from lagrangian_ff.studies.common.study import Numbers, failures

Comparison = dict[str, Any]
"""`claim` in words; `joints`, from their number as text to whether it `holds`, the `means` behind
it by model, and over how many `robots`."""
ByRobot = dict[int, Line]


def numbers_of(lines: Sequence[Line], comparisons: Sequence[Comparison]) -> Numbers:
    """The numbers of a study, for JSON.

    Returns:
        `cases`, how many; `failed`, why some did; `models`, from the name and the number of joints
        to `mean`, `variance` (None of one robot), `median` and `count`, and the most that γ had to
        be raised by; and `findings` by claim, each with the `joints` of its comparison.
    """
    return {
        "cases": len(lines),
        "failed": dict(failures(lines)),
        "models": {
            model: {str(joints): _statistics(by_robot) for joints, by_robot in by_joints.items()}
            for model, by_joints in by_model(lines).items()
        },
        "findings": {each["claim"]: _finding(each) for each in comparisons},
    }


def _finding(comparison: Comparison) -> Finding:
    """Whether a claim holds at every number of joints, and at which."""
    rows = comparison["joints"]
    holds = [n for n, row in rows.items() if row["holds"]]
    fails = [n for n, row in rows.items() if not row["holds"]]
    said = f"at {', '.join(holds)} joints" if holds else "nowhere"
    said += f"; not at {', '.join(fails)}" if fails and holds else ""
    return finding(not fails, f"{comparison['claim']}: {said}", joints=rows)


def by_model(lines: Sequence[Line]) -> dict[str, dict[int, ByRobot]]:
    """The lines by model, number of joints and robot, models in the order of the lines."""
    found: dict[str, dict[int, ByRobot]] = {}
    for line in lines:
        if "failed" not in line:
            of_model = found.setdefault(line["model"], {})
            of_model.setdefault(line["joints"], {})[line["robot"]] = line
    return {model: dict(sorted(held.items())) for model, held in found.items()}


def _statistics(by_robot: ByRobot) -> dict[str, Any]:
    errors = [line["error"] for line in by_robot.values()]
    return {
        "mean": float(np.mean(errors)),
        "variance": float(np.var(errors, ddof=1)) if len(errors) > 1 else None,
        "median": float(np.median(errors)),
        "count": len(errors),
        "gamma_raised": max(line["gamma_raised"] for line in by_robot.values()),
    }


def order(lines: Sequence[Line], better_first: Sequence[str], least_joints: int = 1) -> Comparison:
    """Whether models have mean errors in this order, over the robots that all of them learned.

    Args:
        lines: of the study.  better_first: models by their names.
        least_joints: where it is claimed.
    """
    held = by_model(lines)
    found: dict[str, dict[str, Any]] = {}
    for joints in sorted({n for model in better_first for n in held.get(model, {})}):
        each = [held.get(model, {}).get(joints, {}) for model in better_first]
        robots = set.intersection(*(set(one) for one in each))
        if joints < least_joints or not robots:
            continue
        means = [float(np.mean([one[robot]["error"] for robot in robots])) for one in each]
        found[str(joints)] = {
            "holds": bool(np.all(np.diff(means) > 0.0)),
            "means": dict(zip(better_first, means, strict=True)),
            "robots": len(robots),
        }
    return {"claim": " < ".join(better_first), "joints": found}
