"""What changed since a model was identified, as text."""

from collections.abc import Mapping, Sequence
from typing import Any

from lagrangian_ff.cli.common.console import Console
from lagrangian_ff.cli.text.diagnose import chance
from lagrangian_ff.cli.text.layout import number, table


def say_changed(changed: Sequence[Mapping[str, Any]], model: str, console: Console) -> None:
    """The changes, or that there are none.

    Args:
        changed: records of what changed.
        model: the model file.
        console: to tell it to.
    """
    console.say(["", f"what changed since {model} was identified"])
    if not changed:
        console.say("  nothing that stands out: the arm is as it was")
        return
    rows = [
        [
            one["what"],
            ", ".join(one["joints"]),
            number(one["evidence_gain"]),
            chance(one["p_value"]),
            ", ".join(
                f"{name} by {number(change['value'])} {change['unit']}"
                for name, change in one["change"].items()
            )
            or "another mass: a load was attached or taken off",
            number(one["size"]),
        ]
        for one in changed
    ]
    console.say(table(["what", "joint", "gain", "p", "changed", "rms [N·m]"], rows))
    for one in changed:
        ranges = [
            f"{name} by {number(change['low'])} to {number(change['high'])} {change['unit']}"
            for name, change in one["change"].items()
            if "low" in change
        ]
        if ranges:
            console.paragraph(f"{one['what']}, 90 % intervals: {', '.join(ranges)}", "  ", "    ")
        if one["rivals"]:
            alike = ", ".join(one["rivals"])
            console.paragraph(f"{one['what']}: {alike} would explain as much", "  ", "    ")
