"""Maps with a row for each joint: what its error depends on, and when it was large."""

from collections.abc import Mapping, Sequence
from typing import Any

from lagrangian_ff.report.colours import HEAT
from lagrangian_ff.report.interactive.plot import Plot, axis

ROW = 34
"""Pixels a joint."""


def dependence_plot(bins: Sequence[Mapping[str, Any]]) -> Plot:
    """How much of each joint's squared error a function of one coordinate would take away.

    Args:
        bins: of a record of compare.
    """
    joints = list(dict.fromkeys(one["joint"] for one in bins))
    labels = dict.fromkeys((one["coordinate"], one["label"]) for one in bins)
    found = {(one["joint"], one["coordinate"]): 100.0 * one["explained"] for one in bins}
    values = [[found.get((joint, name)) for name, _ in labels] for joint in joints]
    return _map(
        [_wrapped(label) for _, label in labels], joints, values,
        "%{y}: %{z:.0f} % of its squared error<br>follows %{x}<extra></extra>",
        [[_text(value) for value in row] for row in values], top=60.0,
    )  # fmt: skip


def blocks_plot(record: Mapping[str, Any]) -> Plot:
    """The error of each joint in each block of time, relative to its usual error.

    Args:
        record: of compare.
    """
    blocks, joints = record["blocks"], list(record["joints"])
    values = [
        [
            block["joints"][joint] / usual if (usual := record["joints"][joint]["rmse"]) else None
            for block in blocks
        ]
        for joint in joints
    ]
    middles = [0.5 * (block["begin"] + block["end"]) for block in blocks]
    plot = _map(
        middles, joints, values,
        "%{y} at %{x:.0f} s: %{z:.2g} × its rms error<extra></extra>", None, top=3.0,
    )  # fmt: skip
    layout = {**plot.layout, "xaxis": axis("time [s]", showgrid=False)}
    return Plot(plot.data, layout, plot.height + 20)


def _map(
    columns: Sequence[Any],
    joints: Sequence[str],
    values: Sequence[Sequence[float | None]],
    hover: str,
    text: Sequence[Sequence[str]] | None,
    top: float,
) -> Plot:
    trace: dict[str, Any] = {
        "type": "heatmap", "x": list(columns), "y": list(joints), "z": values,
        "colorscale": [list(stop) for stop in HEAT], "zmin": 0.0, "zmax": top,
        "showscale": False, "hovertemplate": hover, "xgap": 2, "ygap": 2, "hoverongaps": False,
    }  # fmt: skip
    if text is not None:
        trace |= {"text": text, "texttemplate": "%{text}", "textfont": {"size": 12}}
    layout = {
        "xaxis": axis(side="top" if text is not None else "bottom", showgrid=False),
        "yaxis": axis(autorange="reversed", showgrid=False),
        "margin": {"l": 70, "r": 10, "t": 10, "b": 10},
    }
    return Plot([trace], layout, 70 + ROW * len(joints))


def _text(value: float | None) -> str:
    return "" if value is None or value < 0.5 else f"{value:.0f} %"


def _wrapped(label: str) -> str:
    """A label of at most two lines."""
    words = label.split()
    if len(label) <= 12 or len(words) == 1:
        return label
    cut = min(
        range(1, len(words)),
        key=lambda k: max(len(" ".join(words[:k])), len(" ".join(words[k:]))),
    )
    return f"{' '.join(words[:cut])}<br>{' '.join(words[cut:])}"
