"""RMS tracking error of each joint, one bar a run."""

from collections.abc import Mapping, Sequence

import numpy as np
from matplotlib.figure import Figure

from lagrangian_ff.report.colours import FRAME, INK, RUNS
from lagrangian_ff.report.numbers import mrad
from lagrangian_ff.report.style import legend_above, new_figure, styled
from lagrangian_ff.report.tracking import Tracking

FILLED = 0.84  # of the room between joints


def tracking_bars_figure(trajectories: Mapping[str, Sequence[Tracking]]) -> Figure:
    """Draw a panel for each trajectory, with the joints side by side and all of them last.

    Args:
        trajectories: name of the trajectory to its runs; the same runs for each.

    Raises:
        ValueError: nothing to draw.
    """
    if not trajectories or not all(trajectories.values()):
        raise ValueError("expected at least one trajectory with at least one run")
    with styled():
        figure = new_figure(0.5 + 2.5 * len(trajectories))
        panels = figure.subplots(len(trajectories), 1, squeeze=False)[:, 0]
        for axes, (name, runs) in zip(panels, trajectories.items(), strict=True):
            groups = [*runs[0].joints, "all joints"]
            width = FILLED / len(runs)
            for k, (colour, run) in enumerate(zip(RUNS, runs, strict=False)):
                heights = 1e3 * np.append(run.rms, run.total)
                places = np.arange(len(groups)) + (k - 0.5 * (len(runs) - 1)) * width
                axes.bar(places, heights, 0.92 * width, color=colour, label=run.label)
                for place, height in zip(places, heights, strict=True):
                    axes.annotate(
                        mrad(1e-3 * height), (place, height), (0, 2), textcoords="offset points",
                        ha="center", fontsize=6.5, color=INK,
                    )  # fmt: skip
            axes.axvline(len(groups) - 1.5, color=FRAME, linewidth=0.8)
            axes.set_xticks(np.arange(len(groups)), groups)
            axes.set_xlim(-0.5, len(groups) - 0.5)
            axes.grid(visible=False, axis="x")
            axes.margins(y=0.12)
            axes.set_ylabel("RMS error [mrad]")
            axes.set_title(name)
        handles, labels = panels[0].get_legend_handles_labels()
        legend_above(figure, handles, labels)
    return figure
