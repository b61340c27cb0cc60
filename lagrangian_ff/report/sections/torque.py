"""How well a model predicts torque, in numbers and over time."""

from textwrap import wrap
from typing import Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from lagrangian_ff.arrays import Floats, Ints
from lagrangian_ff.diagnosis import Comparison
from lagrangian_ff.diagnosis.compare import Interval
from lagrangian_ff.numbers import DASH, percent, typeset
from lagrangian_ff.recording import Motion
from lagrangian_ff.report import html
from lagrangian_ff.report.colours import MEASURED, PREDICTED, RESIDUAL
from lagrangian_ff.report.page import Section
from lagrangian_ff.report.style import broken, legend_above, new_figure, styled, symmetric, thinned

LETTERS = 45
"""The letters of a title that fit into half of the figure's width."""


def torque_section(comparison: Comparison, picture: bytes, title: str, lead: str) -> Section:
    """Return table and figure, the PNG of `torque_figure`, of measured and predicted torque.

    The lead says which motion it is, and whether the model has seen it.
    """
    score, tau, interval = comparison.score, comparison.motion.tau, comparison.interval
    spread = tau.std(axis=0)
    rows = [
        [
            joint,
            *(typeset(float(one[n])) for one in (spread, score.rmse)),
            percent(float(score.rmse[n] / spread[n])) if spread[n] > 0.0 else DASH,
            typeset(float(score.nmse[n])),
            *([percent(float(interval.covered[n]))] if interval else []),
        ]
        for n, joint in enumerate(score.joints)
    ]
    header = ["joint", "torque's spread [N·m]", "RMS error [N·m]", "error / spread", "nMSE"]
    header += ["inside its interval"] if interval else []
    shown = html.figure(
        picture,
        "measured and predicted torque of each joint over time, with the residual",
        "Upper plots: measured torque (grey) and the model's prediction (blue). Lower plots: what "
        "is left between them, on the same scale."
        + (" Shaded: where 90 % of the measured torques should be." if interval else ""),
    )
    small = html.note(
        "Spread is the standard deviation of the measured torque. nMSE is the mean squared error "
        "over its square: 0 is perfect, 1 is no better than the mean. "
        f"{percent(comparison.outside)} of the samples lie outside the range of motion the model "
        "was identified on."
    )
    return Section(title, lead, html.table(header, rows, strong=3) + shown + small)


def torque_figure(motion: Motion, predicted: Floats, interval: Interval | None = None) -> Figure:
    """Draw each joint twice on one time axis: the torques above, the residual below.

    Both have the same N·m an inch, so that the size of the error is seen and not only its shape.

    Args:
        motion: what was measured.
        predicted: (M, N) N·m of the model on the same samples.
        interval: drawn behind the lines if it is given.

    Raises:
        ValueError: the prediction is not of this motion.
    """
    if predicted.shape != motion.tau.shape:
        raise ValueError(f"prediction of {predicted.shape} for torques of {motion.tau.shape}")
    count = len(motion.joints)
    columns = 1 if count == 1 else 2
    rows = -(-count // columns)
    elapsed = motion.time - motion.time.min()
    with styled():
        figure = new_figure(0.7 + 2.3 * rows)
        grid = figure.add_gridspec(rows, columns)
        for n, joint in enumerate(motion.joints):
            cell = grid[n // columns, n % columns]
            measured, modelled = motion.tau[:, n], predicted[:, n]
            both = np.concatenate([measured, modelled])
            middle = 0.5 * float(both.max() + both.min())
            reach = 0.54 * max(float(np.ptp(both)), 1e-9)
            below = max(float(np.abs(measured - modelled).max()), 0.2 * reach)
            inner = cell.subgridspec(2, 1, height_ratios=(2 * reach, 2.16 * below), hspace=0.06)
            torque = figure.add_subplot(inner[0])
            residual = figure.add_subplot(inner[1], sharex=torque)
            if interval is not None:
                at, half = interval.at, interval.reach[:, n]
                segment = motion.segment[at]
                _band(torque, elapsed[at], segment, modelled[at], half)
                _band(residual, elapsed[at], segment, np.zeros(len(at)), half)
            _line(torque, elapsed, motion, measured, MEASURED, 2.4, "measured")
            _line(torque, elapsed, motion, modelled, PREDICTED, 1.0, "predicted")
            torque.set_ylim(middle - reach, middle + reach)
            torque.set_title(_title(joint, measured, modelled))
            torque.set_ylabel("N·m")
            torque.tick_params(labelbottom=False)
            left = measured - modelled
            _line(residual, elapsed, motion, left, RESIDUAL, 0.8, "measured − predicted")
            symmetric(residual, below)
            residual.yaxis.set_major_locator(MaxNLocator(2, symmetric=True))
            residual.set_xlim(0.0, max(float(elapsed.max()), 1e-9))
            if n >= count - columns:
                residual.set_xlabel("time [s]")
        shown: list[Artist] = [line for axes in figure.axes[:2] for line in axes.get_lines()]
        if interval is not None:
            shown.append(figure.axes[0].collections[0])
        legend_above(figure, shown, [str(each.get_label()) for each in shown])
    return figure


def _title(joint: str, measured: Floats, predicted: Floats) -> str:
    rmse = float(np.sqrt(np.mean((measured - predicted) ** 2)))
    spread = float(np.std(measured))
    share = f", {percent(rmse / spread)} of the torque's spread" if spread > 0.0 else ""
    return "\n".join([*wrap(joint, LETTERS), f"RMS error {typeset(rmse, 2)} N·m{share}"])


def _band(axes: Axes, time: Floats, segment: Ints, middle: Floats, reach: Floats) -> None:
    at, around = broken(time, segment, middle)
    _, half = broken(time, segment, reach)
    style: dict[str, Any] = {"color": PREDICTED, "alpha": 0.16, "linewidth": 0.0}
    axes.fill_between(at, around - half, around + half, label="90 % interval", **style)


def _line(
    axes: Axes, time: Floats, motion: Motion, values: Floats, colour: str, width: float, label: str
) -> None:
    some, part, segment = thinned(time, values, motion.segment.astype(np.float64))
    some, part = broken(some, segment.astype(np.int64), part)
    axes.plot(some, part, color=colour, linewidth=width, label=label)
