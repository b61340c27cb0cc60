"""How a model came to be what it is, as text."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

from lagrangian_ff.cli.common.console import Console, table
from lagrangian_ff.numbers import chance, number

if TYPE_CHECKING:
    from lagrangian_ff.identification.history import ErrorChange, Step


def say_history(steps: "Sequence[Step]", console: Console) -> None:
    """Print the steps as a table, the error of each joint, and why each step was made."""
    rows = [
        [
            step.added,
            (step.when or "-").replace("T", " ")[:16],
            step.reason.verdict or "-",
            *map(number, (step.error_before, step.error_after, step.reason.evidence_gain)),
            chance(step.reason.p_value),
        ]
        for step in steps
    ]
    header = ["step", "when (UTC)", "verdict", "error before [N·m]", "after", "gain", "p"]
    console.say(table(header, rows))
    judged = "; ".join(dict.fromkeys(step.judged_on for step in steps))
    console.paragraph(f"error: rms over all joints, judged on {judged}", "  ")
    console.say(["", "the error of each joint after each step, N·m"])
    names = [step.added if k == 0 else f"+ {step.added}" for k, step in enumerate(steps)]
    errors = [
        [joint, *(number(step.joints[joint].after) for step in steps)] for joint in steps[0].joints
    ]
    console.say(table(["joint", *names], errors))
    reasoned = [step for step in steps if step.reason.why]
    if reasoned:
        console.say(["", "why"])
    for step in reasoned:
        console.paragraph(f"{step.added}: {step.reason.why}", "  ", "    ")


def before_after_table(joints: "Mapping[str, ErrorChange]") -> list[str]:
    """Return the error of each joint before and after one step."""
    rows = []
    for name, error in joints.items():
        change = "-" if error.left is None else f"{100.0 * (error.left - 1.0):+.1f} %"
        rows.append([name, number(error.before), number(error.after), change])
    return table(["joint", "error before [N·m]", "after", "change"], rows)
