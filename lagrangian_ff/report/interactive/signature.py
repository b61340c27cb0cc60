"""What is left of the torque over the coordinate in which an effect shows, and the effect."""

from collections.abc import Mapping
from typing import Any

from lagrangian_ff.report.colours import EFFECT, RESIDUAL
from lagrangian_ff.report.interactive.plot import Plot, axis, band, line
from lagrangian_ff.report.words import spoken


def signature_plot(signature: Mapping[str, Any], effect: str) -> Plot:
    """Draw the mean residual with its band, and the effect as it was fitted.

    Args:
        signature: of a finding in a record of diagnose.
        effect: its name.
    """
    x = signature["x"]
    many = "lines" if len(x) > 40 else "lines+markers"
    data = [
        band(x, signature["low"], signature["high"], RESIDUAL),
        line(
            x, signature["residual"], "what the model leaves", RESIDUAL, mode=many,
            marker={"size": 5},
        ),
        line(x, signature["effect"], effect, EFFECT, width=2.6),
    ]  # fmt: skip
    unit = f" [{signature['unit']}]" if signature.get("unit") else ""
    layout = {
        "xaxis": axis(f"{spoken(signature['coordinate'])}{unit}"),
        "yaxis": axis("torque [N·m]"),
        "showlegend": True,
        "hovermode": "x unified",
    }
    return Plot(data, layout, 330)
