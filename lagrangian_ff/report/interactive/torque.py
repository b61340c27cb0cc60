"""Measured and predicted torque of a joint over time, with what is left between them."""

from collections.abc import Mapping
from typing import Any

from lagrangian_ff.report.colours import MEASURED, PREDICTED, RESIDUAL
from lagrangian_ff.report.interactive.plot import Plot, axis, line


def torque_plot(series: Mapping[str, Any], joint: str) -> Plot:
    """Draw the torque above and the residual below, over one time.

    Args:
        series: of a record of compare.
        joint: its name.
    """
    time, measured, predicted = _broken(series, joint)
    left: list[float | None] = [
        None if m is None or p is None else m - p
        for m, p in zip(measured, predicted, strict=True)
    ]  # fmt: skip
    data = [
        line(time, measured, "measured", MEASURED, width=2.4),
        line(time, predicted, "predicted", PREDICTED, width=1.2),
        line(time, left, "measured − predicted", RESIDUAL, width=1.2, yaxis="y2"),
    ]
    layout = {
        "xaxis": axis("time [s]", anchor="y2"),
        "yaxis": axis("torque [N·m]", domain=[0.42, 1.0]),
        "yaxis2": axis("left [N·m]", domain=[0.0, 0.34]),
        "hovermode": "x unified",
        "showlegend": True,
    }
    return Plot(data, layout, 400)


def _broken(series: Mapping[str, Any], joint: str) -> tuple[list[Any], list[Any], list[Any]]:
    """Time and torques with a break where the recording was interrupted."""
    columns: tuple[list[Any], list[Any], list[Any]] = ([], [], [])
    values = series["joints"][joint]
    before = None
    for time, segment, *torques in zip(
        series["time"], series["segment"], values["measured"], values["predicted"], strict=True
    ):
        if before is not None and segment != before:
            for column in columns:
                column.append(None)
        before = segment
        for column, value in zip(columns, (time, *torques), strict=True):
            column.append(value)
    return columns
