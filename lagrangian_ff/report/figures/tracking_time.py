"""Tracking error of each joint over time, run over run."""

from collections.abc import Sequence

import numpy as np
from matplotlib.figure import Figure

from lagrangian_ff.report.colours import RUNS
from lagrangian_ff.report.numbers import mrad
from lagrangian_ff.report.style import legend_above, new_figure, styled, symmetric, thinned
from lagrangian_ff.report.tracking import Tracking


def tracking_time_figure(runs: Sequence[Tracking]) -> Figure:
    """Draw each joint's error in mrad, the runs over one another in the given order.

    Args:
        runs: of the same trajectory and joints.

    Raises:
        ValueError: no runs, or of different joints.
    """
    if not runs or any(run.joints != runs[0].joints for run in runs):
        raise ValueError("expected at least one run, all of the same joints")
    joints = runs[0].joints
    columns = 1 if len(joints) == 1 else 2
    rows = -(-len(joints) // columns)
    with styled():
        figure = new_figure(0.7 + 1.55 * rows)
        grid = figure.subplots(rows, columns, sharex=True, squeeze=False)
        for n, axes in enumerate(grid.flat):
            if n >= len(joints):
                axes.remove()
                continue
            for colour, run in zip(RUNS, runs, strict=False):
                time, error = thinned(run.time, 1e3 * run.error[:, n])
                axes.plot(time, error, color=colour, label=run.label)
            symmetric(axes, max(1e3 * float(np.abs(run.error[:, n]).max()) for run in runs))
            axes.set_xlim(0.0, max(float(run.time[-1]) for run in runs))
            axes.set_title(f"{joints[n]}   RMS {_steps(runs, n)} mrad")
            axes.set_ylabel("mrad")
            if n >= len(joints) - columns:
                axes.set_xlabel("time [s]")
                axes.tick_params(labelbottom=True)
        handles, labels = figure.axes[0].get_legend_handles_labels()
        legend_above(figure, handles, labels)
    return figure


def _steps(runs: Sequence[Tracking], joint: int) -> str:
    return " → ".join(mrad(float(run.rms[joint])) for run in runs)
