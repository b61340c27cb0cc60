"""How a model came to be what it is, as text."""

from collections.abc import Mapping, Sequence
from typing import Any

from lagrangian_ff.cli.common.console import Console, table
from lagrangian_ff.numbers import chance, number


def say_history(record: Mapping[str, Any], console: Console) -> None:
    """Print the steps as a table, the error of each joint, and why each step was made."""
    steps: Sequence[Mapping[str, Any]] = record["steps"]
    rows = [
        [
            step["added"],
            str(step.get("when") or "-").replace("T", " ")[:16],
            step.get("verdict") or "-",
            *(number(step.get(key)) for key in ("error_before", "error_after", "evidence_gain")),
            chance(step.get("p_value")),
        ]
        for step in steps
    ]
    header = ["step", "when (UTC)", "verdict", "error before [N·m]", "after", "gain", "p"]
    console.say(table(header, rows))
    judged = "; ".join(dict.fromkeys(str(step["judged_on"]) for step in steps))
    console.paragraph(f"error: rms over all joints, judged on {judged}", "  ")
    console.say(["", "the error of each joint after each step, N·m"])
    names = [step["added"] if k == 0 else f"+ {step['added']}" for k, step in enumerate(steps)]
    errors = [
        [joint, *(number(step["joints"][joint]["after"]) for step in steps)]
        for joint in steps[0]["joints"]
    ]
    console.say(table(["joint", *names], errors))
    reasoned = [step for step in steps if step.get("why")]
    if reasoned:
        console.say(["", "why"])
    for step in reasoned:
        console.paragraph(f"{step['added']}: {step['why']}", "  ", "    ")


def before_after_table(joints: Mapping[str, Mapping[str, float]]) -> list[str]:
    """Return the error of each joint before and after one step."""
    rows = []
    for name, error in joints.items():
        before, after = error["before"], error["after"]
        change = f"{100.0 * (after / before - 1.0):+.1f} %" if before > 0.0 else "-"
        rows.append([name, number(before), number(after), change])
    return table(["joint", "error before [N·m]", "after", "change"], rows)


def fall_table(steps: Sequence[Mapping[str, Any]]) -> list[str]:
    """Return the error of all joints, and of the joint concerned, after each addition."""
    rows = []
    for step in steps:
        name, own = f"+ {step['added']}" if step["added"] else "as it was", ""
        if step.get("joint"):
            own = f"{step['joint']}: {number(step['before'])} -> {number(step['after'])}"
        rows.append([name, number(step["error"]), own])
    return table(["model", "all joints", "its joint"], rows)
