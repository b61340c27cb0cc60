"""Measured and predicted torque of a joint over time, with what is left between them."""

from collections.abc import Mapping, Sequence
from typing import Any

from lagrangian_ff.report.colours import MEASURED, PREDICTED, RESIDUAL
from lagrangian_ff.report.interactive.plot import Plot, Trace, axis, band, line

Values = list[float | None]


def torque_plot(series: Mapping[str, Any], joint: str) -> Plot:
    """Draw the torque above and the residual below, over one time.

    Where the series tells how far the 90 % intervals reach, they lie behind the lines as a band
    around the prediction and, below, around zero.

    Args:
        series: of a record of compare.
        joint: its name.
    """
    values = series["joints"][joint]
    reached = values.get("reach")
    time, measured, predicted, *reach = _broken(
        series["segment"],
        [series["time"], values["measured"], values["predicted"], *([reached] if reached else [])],
    )
    data = [
        *(_bands(time, predicted, reach[0]) if reach else ()),
        line(time, measured, "measured", MEASURED, width=2.4),
        line(time, predicted, "predicted", PREDICTED, width=1.2),
        line(time, _sum(measured, predicted, -1.0), "measured − predicted", RESIDUAL, width=1.2,
             yaxis="y2"),
    ]  # fmt: skip
    layout = {
        "xaxis": axis("time [s]", anchor="y2"),
        "yaxis": axis("torque [N·m]", domain=[0.42, 1.0]),
        "yaxis2": axis("left [N·m]", domain=[0.0, 0.34]),
        "hovermode": "x unified",
        "showlegend": True,
    }
    return Plot(data, layout, 400)


def _bands(time: Values, predicted: Values, reach: Values) -> list[Trace]:
    """Around the prediction and around zero; one entry of the legend switches both."""
    zero: Values = [None if one is None else 0.0 for one in reach]
    common = {"name": "90 % interval", "legendgroup": "interval"}
    return [
        band(time, _sum(middle, reach, -1.0), _sum(middle, reach, 1.0), PREDICTED,
             **common, **place)
        for middle, place in ((predicted, {"showlegend": True}), (zero, {"yaxis": "y2"}))
    ]  # fmt: skip


def _sum(one: Values, other: Values, sign: float) -> Values:
    """One plus or minus the other, None where either is."""
    return [
        None if a is None or b is None else a + sign * b for a, b in zip(one, other, strict=True)
    ]


def _broken(segments: Sequence[int], columns: Sequence[Sequence[float | None]]) -> list[Values]:
    """Columns with a break where the recording was interrupted."""
    out: list[Values] = [[] for _ in columns]
    before = None
    for segment, *row in zip(segments, *columns, strict=True):
        if before is not None and segment != before:
            for column in out:
                column.append(None)
        before = segment
        for column, value in zip(out, row, strict=True):
            column.append(value)
    return out
