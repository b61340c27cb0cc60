"""How a model came to be what it is, as text."""

from collections.abc import Mapping, Sequence
from typing import Any

from lagrangian_ff.cli.common.console import Console
from lagrangian_ff.cli.text.diagnose import chance
from lagrangian_ff.cli.text.layout import number, table


def say_history(record: Mapping[str, Any], console: Console) -> None:
    """The steps as a table, the error of each joint, and why each step was made.

    Args:
        record: of history.
        console: to tell it to.
    """
    steps: Sequence[Mapping[str, Any]] = record["steps"]
    rows = [
        [
            step["added"],
            str(step.get("when") or "-").replace("T", " ")[:16],
            step.get("verdict") or "-",
            number(step.get("error_before")),
            number(step.get("error_after")),
            number(step.get("evidence_gain")),
            chance(step.get("p_value")),
        ]
        for step in steps
    ]
    console.say(
        table(["step", "when (UTC)", "verdict", "error before [N·m]", "after", "gain", "p"], rows)
    )
    judged = "; ".join(dict.fromkeys(str(step["judged_on"]) for step in steps))
    console.paragraph(f"error: rms over all joints, judged on {judged}", "  ")
    console.say(["", "the error of each joint after each step, N·m"])
    console.say(joint_table(steps))
    told = [step for step in steps if step.get("why")]
    if told:
        console.say(["", "why"])
    for step in told:
        console.paragraph(f"{step['added']}: {step['why']}", "  ", "    ")


def joint_table(steps: Sequence[Mapping[str, Any]]) -> list[str]:
    """The error of each joint, a column a step."""
    names = [step["added"] if k == 0 else f"+ {step['added']}" for k, step in enumerate(steps)]
    rows = [
        [joint, *(number(step["joints"][joint]["after"]) for step in steps)]
        for joint in steps[0]["joints"]
    ]
    return table(["joint", *names], rows)


def before_after_table(joints: Mapping[str, Mapping[str, float]]) -> list[str]:
    """The error of each joint before and after one step."""
    rows = []
    for name, error in joints.items():
        before, after = error["before"], error["after"]
        change = f"{100.0 * (after / before - 1.0):+.1f} %" if before > 0.0 else "-"
        rows.append([name, number(before), number(after), change])
    return table(["joint", "error before [N·m]", "after", "change"], rows)


def fall_table(steps: Sequence[Mapping[str, Any]]) -> list[str]:
    """The error of all joints, and of the joint concerned, after each addition."""
    rows = [
        [
            f"+ {step['added']}" if step["added"] else "as it was",
            number(step["error"]),
            f"{step['joint']}: {number(step['before'])} -> {number(step['after'])}"
            if step.get("joint")
            else "",
        ]
        for step in steps
    ]
    return table(["model", "all joints", "its joint"], rows)
