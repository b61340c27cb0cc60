"""How the error fell as effects were added to a model."""

import math
from collections.abc import Mapping, Sequence
from datetime import datetime
from typing import TYPE_CHECKING, Any

from lagrangian_ff.numbers import DASH, chance, typeset
from lagrangian_ff.report import html
from lagrangian_ff.report.colours import AFTER, BEFORE, FAINT, faded, of_joint
from lagrangian_ff.report.page import Section
from lagrangian_ff.report.plot import Plot, axis, embed, line
from lagrangian_ff.words import sentence, spoken

if TYPE_CHECKING:
    from lagrangian_ff.identification.history import History, Step


def steps_section(history: "History") -> Section:
    """Return the fall of the error over a model's history, and a table of the steps."""
    steps = history.steps
    known = [(_name(step), step.error_after) for step in steps if step.error_after is not None]
    parts = []
    if len(known) > 1:
        names, errors = zip(*known, strict=True)
        parts.append(embed(fall_plot(names, errors), "error after each step"))
    rows = [
        [
            spoken(step.added),
            _day(step.when),
            step.reason.verdict or DASH,
            *map(typeset, (step.error_before, step.error_after, step.reason.evidence_gain)),
            chance(step.reason.p_value, DASH),
        ]
        for step in steps
    ]
    header = ["step", "when", "verdict", "error before [N·m]", "after [N·m]", "gain", "p"]
    parts.append(html.table(header, rows, words=3, strong=4))
    judged = dict.fromkeys(step.judged_on for step in steps if step.judged_on)
    if judged:
        parts.append(html.note(f"Errors are judged on {'; '.join(judged)}."))
    return Section(
        "Step by step",
        "Each step adds one effect and fits the model again. The error is of data that took no "
        "part in the fit.",
        "".join(parts),
    )


def reasons_section(history: "History") -> Section | None:
    """Return why each step was made."""
    texts = [
        f"{spoken(step.added)}: {sentence(step.reason.why)}"
        for step in history.steps
        if step.reason.why
    ]
    return Section("Why", "", html.steps(texts)) if texts else None


def each_joint_section(history: "History") -> Section | None:
    """Return the error of every joint over the steps of a model's history."""
    steps = [step for step in history.steps if step.joints]
    joints = [
        joint
        for joint in (steps[0].joints if steps else ())
        if all(joint in step.joints for step in steps)
    ]
    if len(steps) < 2 or not joints:
        return None
    names = [_name(step) for step in steps]
    errors = {joint: [_after(step, joint) for step in steps] for joint in joints}
    header = ["RMS error [N·m]", *names]
    rows = [[joint, *map(typeset, values)] for joint, values in errors.items()]
    return Section(
        "Each joint",
        "An effect of one joint should help that joint and harm none.",
        embed(joints_fall_plot(names, errors), "each joint's error over the steps")
        + html.table(header, rows, strong=len(names)),
    )


def _name(step: "Step") -> str:
    added = spoken(step.added)
    return added if added == "identified" else f"+ {added}"


def _after(step: "Step", joint: str) -> float:
    error = step.joints[joint].after
    return math.nan if error is None else error


def _day(when: str) -> str:
    if not when:
        return DASH
    try:
        return f"{datetime.fromisoformat(when):%Y-%m-%d %H:%M}"
    except ValueError:
        return when


def fall_plot(names: Sequence[str], errors: Sequence[float], without: float | None = None) -> Plot:
    """Draw the error (N·m) after each step.

    Args:
        without: N·m of the last model without what was found, a dashed line; None for no line.
    """
    drawn = line(
        list(range(len(names))),
        errors,
        "RMS error",
        AFTER,
        width=2.4,
        mode="lines+markers+text",
        marker={"size": 9},
        text=[typeset(error) for error in errors],
        textposition="top center",
        textfont={"size": 12},
        fill="tozeroy",
        fillcolor=faded(AFTER, 0.07),
        hovertemplate="%{y:.3g} N·m<extra></extra>",
        cliponaxis=False,
    )
    highest = max(*errors, without or 0.0)
    height = axis("RMS error on held-back data [N·m]", range=[0, 1.2 * highest])
    layout = {"xaxis": _steps(names), "yaxis": height, "showlegend": without is not None}
    if without is None:
        return Plot([drawn], layout, 320)
    name = f"the last model without what was found: {typeset(without)} N·m"
    level = line(_ends(names), [without, without], name, BEFORE, mode="lines", hoverinfo="skip")
    level["line"] = {**level["line"], "dash": "dash"}
    return Plot([level, {**drawn, "showlegend": False}], layout, 320)


def joints_fall_plot(
    names: Sequence[str],
    joints: Mapping[str, Sequence[float]],
    without: Mapping[str, float] | None = None,
) -> Plot:
    """Draw each joint's error (N·m) after each step, as a share of what it was at first.

    Args:
        without: by joint, N·m to draw it as a share of instead: of the last model without what was
            found.
    """
    places = list(range(len(names)))
    hover = "%{y:.0f} %, %{customdata:.3g} N·m"
    look: dict[str, Any] = {"width": 2, "mode": "lines+markers", "hovertemplate": hover}
    data = []
    for k, (joint, errors) in enumerate(joints.items()):
        whole = without[joint] if without else errors[0]
        shares = [100.0 * error / whole if whole else 100.0 for error in errors]
        data.append(line(places, shares, joint, of_joint(k), customdata=list(errors), **look))
    layout = {
        "xaxis": _steps(names),
        "yaxis": axis(
            "% of that without what was found" if without else "% of the first error",
            rangemode="tozero",
        ),
        "showlegend": True,
        "hovermode": "x unified",
    }
    return Plot(data, layout, 340)


def _steps(names: Sequence[str]) -> dict[str, object]:
    return axis(
        tickvals=list(range(len(names))),
        ticktext=[spoken(name).replace(" on ", "<br>on ") for name in names],
        range=_ends(names),
        tickfont={"size": 12, "color": FAINT},
        showgrid=False,
        zeroline=False,
    )


def _ends(names: Sequence[str]) -> list[float]:
    return [-0.35, max(0.35, len(names) - 0.65)]
