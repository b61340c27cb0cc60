"""How the error falls as effects are added: in a diagnosis, and in the history of a model."""

import math
from collections.abc import Mapping, Sequence
from datetime import datetime
from typing import Any

from lagrangian_ff.numbers import DASH, chance, percent, typeset
from lagrangian_ff.report import html
from lagrangian_ff.report.colours import AFTER, FAINT, RUNS, faded
from lagrangian_ff.report.page import Section
from lagrangian_ff.report.plot import Plot, axis, embed, line
from lagrangian_ff.words import sentence, spoken


def fall_section(record: Mapping[str, Any]) -> Section | None:
    """Return the error after each step of a diagnosis; None if no step was made."""
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


def steps_section(record: Mapping[str, Any]) -> Section:
    """Return the fall of the error over a model's history, and a table of the steps."""
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
            step.get("verdict") or DASH,
            *(typeset(step.get(key)) for key in ("error_before", "error_after", "evidence_gain")),
            chance(step.get("p_value"), DASH),
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
    """Return why each step was made."""
    reasoned = [step for step in record["steps"] if step.get("why")]
    if not reasoned:
        return None
    texts = [f"{spoken(step['added'])}: {sentence(step['why'])}" for step in reasoned]
    return Section("Why", "", html.steps(texts))


def each_joint_section(record: Mapping[str, Any]) -> Section | None:
    """Return the error of every joint over the steps of a model's history."""
    steps = [step for step in record["steps"] if step.get("joints")]
    joints = [
        joint
        for joint in (steps[0]["joints"] if steps else ())
        if all(joint in step["joints"] for step in steps)
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


def _name(step: Mapping[str, Any]) -> str:
    added = spoken(str(step["added"]))
    return added if added == "identified" else f"+ {added}"


def _after(step: Mapping[str, Any], joint: str) -> float:
    error = step["joints"][joint].get("after")
    return math.nan if error is None else float(error)


def _day(when: str | None) -> str:
    if not when:
        return DASH
    try:
        return f"{datetime.fromisoformat(when):%Y-%m-%d %H:%M}"
    except ValueError:
        return when


def fall_plot(names: Sequence[str], errors: Sequence[float]) -> Plot:
    """Draw the error (N·m) after each step; the first is that of the model as it was."""
    places = list(range(len(names)))
    data = [
        line(
            places, errors, "RMS error", AFTER, width=2.4, mode="lines+markers+text",
            marker={"size": 9}, text=[typeset(error) for error in errors],
            textposition="top center", textfont={"size": 12},
            fill="tozeroy", fillcolor=faded(AFTER, 0.07),
            hovertemplate="%{y:.3g} N·m<extra></extra>", cliponaxis=False,
        )
    ]  # fmt: skip
    layout = {
        "xaxis": _steps(names),
        "yaxis": axis("RMS error on held-back data [N·m]", range=[0, 1.2 * max(errors)]),
    }
    return Plot(data, layout, 320)


def joints_fall_plot(names: Sequence[str], joints: Mapping[str, Sequence[float]]) -> Plot:
    """Draw each joint's error (N·m) after each step, as a share of what it was at first."""
    places = list(range(len(names)))
    data = []
    for k, (joint, errors) in enumerate(joints.items()):
        shares = [100.0 * error / errors[0] if errors[0] else 100.0 for error in errors]
        data.append(
            line(
                places, shares, joint, RUNS[(k + 1) % len(RUNS)], width=2, mode="lines+markers",
                customdata=list(errors), hovertemplate="%{y:.0f} %, %{customdata:.3g} N·m",
            )
        )  # fmt: skip
    layout = {
        "xaxis": _steps(names),
        "yaxis": axis("% of the first error", rangemode="tozero"),
        "showlegend": True,
        "hovermode": "x unified",
    }
    return Plot(data, layout, 340)


def _steps(names: Sequence[str]) -> dict[str, object]:
    return axis(
        tickvals=list(range(len(names))),
        ticktext=[spoken(name).replace(" on ", "<br>on ") for name in names],
        range=[-0.35, max(0.35, len(names) - 0.65)],
        tickfont={"size": 12, "color": FAINT},
        showgrid=False,
        zeroline=False,
    )
