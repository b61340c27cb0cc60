"""The error as effects are added, one step after the other."""

from collections.abc import Mapping, Sequence

from lagrangian_ff.report.colours import AFTER, FAINT, RUNS, faded
from lagrangian_ff.report.interactive.plot import Plot, axis, line
from lagrangian_ff.report.numbers import number
from lagrangian_ff.report.words import spoken


def fall_plot(names: Sequence[str], errors: Sequence[float]) -> Plot:
    """Draw the error over the steps.

    Args:
        names: of the steps; the first is the model as it was.
        errors: N·m on held-back data, after each step.
    """
    places = list(range(len(names)))
    data = [
        line(
            places, errors, "RMS error", AFTER, width=2.4, mode="lines+markers+text",
            marker={"size": 9}, text=[number(error) for error in errors],
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
    """Draw each joint's error over the steps, as a share of what it was at first.

    Args:
        names: of the steps.
        joints: name to N·m after each step.
    """
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
