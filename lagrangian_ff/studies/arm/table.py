"""Errors over speed as lines of text."""

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np

from lagrangian_ff.studies.common.findings import told
from lagrangian_ff.studies.common.study import failures_told

NAME, CELL = 22, 8


def prediction_table(numbers: Mapping[str, Any]) -> list[str]:
    """The error of torque of every model on every trajectory, and what it comes to."""
    unloaded = {f"{name}, unloaded": row for name, row in numbers.get("unloaded", {}).items()}
    return [
        f"{numbers['cases']} cases; RMS error of torque [N·m] on the last two thirds",
        *errors_table({**numbers["curves"], **unloaded}),
        *told(numbers["findings"]),
        *failures_told(numbers["failed"]),
    ]


def errors_table(curves: Mapping[str, Any], unit: float = 1.0) -> list[str]:
    """A row for each curve, a column for each trajectory, and the geometric mean.

    Args:
        curves: see `Errors.record`.
        unit: that errors are given in.
    """
    velocity = {
        speed: v
        for curve in curves.values()
        for speed, v in zip(curve["speed"], curve["velocity"], strict=True)
    }
    speeds = sorted(velocity)
    if not speeds:
        return []
    text = [
        "",
        _row("speed", [*map(str, speeds), "mean"]),
        _row("velocity [rad/s]", [f"{velocity[speed]:.2f}" for speed in speeds]),
    ]
    for name, curve in curves.items():
        by_speed = dict(zip(curve["speed"], curve["rmse"], strict=True))
        cells = [_figure(by_speed[s] / unit) if s in by_speed else "-" for s in speeds]
        # Over other trajectories a mean would be of something else.
        whole = len(by_speed) == len(speeds)
        mean = _figure(np.exp(np.mean(np.log(curve["rmse"]))) / unit) if whole else "-"
        text.append(_row(name, [*cells, mean]))
    return text


def _figure(value: float) -> str:
    return f"{value:.3g}" if value < 100.0 else f"{value:.0f}"


def _row(name: str, cells: Sequence[str] | Iterable[str]) -> str:
    return (f"  {name:<{NAME}}" + "".join(f"{cell:>{CELL}}" for cell in cells)).rstrip()
