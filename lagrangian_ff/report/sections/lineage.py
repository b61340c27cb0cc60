"""What was added to a model, why, and what it did to the error."""

from collections.abc import Mapping, Sequence
from datetime import datetime
from typing import Any

from lagrangian_ff.report import html
from lagrangian_ff.report.interactive import embed
from lagrangian_ff.report.interactive.fall import fall_plot, joints_fall_plot
from lagrangian_ff.report.numbers import number
from lagrangian_ff.report.section import Section
from lagrangian_ff.report.words import chance, sentence, spoken


def steps_section(record: Mapping[str, Any]) -> Section:
    """The fall of the error, and a table of the steps.

    Args:
        record: of history.
    """
    steps: Sequence[Mapping[str, Any]] = record["steps"]
    known = [step for step in steps if step.get("error_after") is not None]
    parts = []
    if len(known) > 1:
        errors = [float(step["error_after"]) for step in known]
        parts.append(
            embed(fall_plot([_name(step) for step in known], errors), "error after each step")
        )
    rows = [
        [
            spoken(step["added"]),
            _day(step.get("when")),
            step.get("verdict") or "–",
            number(_number(step.get("error_before"))),
            number(_number(step.get("error_after"))),
            number(_number(step.get("evidence_gain"))),
            chance(step.get("p_value")),
        ]
        for step in steps
    ]
    header = ["step", "when", "verdict", "error before [N·m]", "after [N·m]", "gain", "p"]
    parts.append(html.table(header, rows, words=3, strong=4))
    judged = list(dict.fromkeys(step["judged_on"] for step in steps if step.get("judged_on")))
    if judged:
        parts.append(html.note(f"Errors are judged on {'; '.join(judged)}."))
    return Section(
        "Step by step",
        "Each step adds one effect and fits the model again. The error is of data that took no "
        "part in the fit.",
        "".join(parts),
    )


def reasons_section(record: Mapping[str, Any]) -> Section | None:
    """Why each step was made.

    Args:
        record: of history.
    """
    told = [step for step in record["steps"] if step.get("why")]
    if not told:
        return None
    texts = [f"{spoken(step['added'])}: {sentence(step['why'])}" for step in told]
    return Section("Why", "", html.steps(texts))


def each_joint_section(record: Mapping[str, Any]) -> Section | None:
    """The error of every joint over the steps.

    Args:
        record: of history.
    """
    steps = [step for step in record["steps"] if step.get("joints")]
    known = [
        (step, {name: _number(one.get("after")) for name, one in step["joints"].items()})
        for step in steps
    ]
    joints = [
        name for name in (known[0][1] if known else {}) if all(name in after for _, after in known)
    ]
    if len(known) < 2 or not joints:
        return None
    names = [_name(step) for step, _ in known]
    errors = {joint: [after[joint] for _, after in known] for joint in joints}
    header = ["RMS error [N·m]", *names]
    rows = [[joint, *map(number, values)] for joint, values in errors.items()]
    return Section(
        "Each joint",
        "An effect of one joint should help that joint and harm none.",
        embed(joints_fall_plot(names, errors), "each joint's error over the steps")
        + html.table(header, rows, strong=len(names)),
    )


def _name(step: Mapping[str, Any]) -> str:
    added = spoken(str(step["added"]))
    return added if added == "identified" else f"+ {added}"


def _day(when: str | None) -> str:
    if not when:
        return "–"
    try:
        return f"{datetime.fromisoformat(when):%Y-%m-%d %H:%M}"
    except ValueError:
        return when


def _number(value: float | None) -> float:
    return float("nan") if value is None else float(value)
