"""How the error falls as effects are added."""

from collections.abc import Mapping
from typing import Any

from lagrangian_ff.report import html
from lagrangian_ff.report.interactive import embed
from lagrangian_ff.report.interactive.fall import fall_plot
from lagrangian_ff.report.numbers import percent
from lagrangian_ff.report.section import Section


def fall_section(record: Mapping[str, Any]) -> Section | None:
    """The error after each step; none where no step was made.

    Args:
        record: of diagnose.
    """
    steps = [step for step in record.get("steps") or [] if step.get("error") is not None]
    if len(steps) < 2:
        return None
    names = ["as it was", *(f"+ {step['added']}" for step in steps[1:])]
    errors = [float(step["error"]) for step in steps]
    small = html.note(f"{percent(errors[-1] / errors[0])} of the first error is left.")
    return Section(
        "The error falls",
        "One effect at a time, each chosen with the ones before it in the model, judged on data "
        "that took no part in the choice.",
        embed(fall_plot(names, errors), "error on held-back data after each step") + small,
    )
