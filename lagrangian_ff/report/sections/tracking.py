"""How far a robot was from its reference, run beside run."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from lagrangian_ff.arrays import Floats
from lagrangian_ff.numbers import mrad
from lagrangian_ff.report import html
from lagrangian_ff.report.colours import FRAME, INK, RUNS
from lagrangian_ff.report.page import Section
from lagrangian_ff.report.style import legend_above, new_figure, styled, symmetric, thinned

FILLED = 0.84  # of the room between joints


@dataclass(frozen=True)
class Tracking:
    """One run along a trajectory.

    Attributes:
        label: what was done differently in this run, e.g. `no feedforward`.
        joints: N names.
        time: (M,) s since the start of the trajectory.
        error: (M, N) rad, reference less measured position.
    """

    label: str
    joints: tuple[str, ...]
    time: Floats
    error: Floats

    @property
    def rms(self) -> Floats:
        """Return the root mean square error of each joint, (N,) rad."""
        return np.sqrt(np.mean(self.error**2, axis=0))

    @property
    def total(self) -> float:
        """Return the root mean square over run and joints, rad."""
        return float(np.sqrt(np.mean(self.error**2)))

    def record(self) -> dict[str, object]:
        """Return the errors for JSON, in rad."""
        return {
            "label": self.label,
            "unit": "rad",
            "rms": self.total,
            "largest": float(np.abs(self.error).max()),
            "joints": {
                name: {"rms": float(self.rms[n]), "largest": float(np.abs(self.error[:, n]).max())}
                for n, name in enumerate(self.joints)
            },
            "samples": len(self.time),
        }


def tracking_section(
    runs: Sequence[Tracking], picture: bytes, title: str, lead: str, *, strong: int | None = None
) -> Section:
    """Return table and figure, the PNG of `tracking_time_figure`, of the runs along one trajectory.

    The first run is what the others are compared with, the strong one is what matters most.
    """
    first = runs[0]
    rows = [
        [joint, *(mrad(float(run.rms[n])) for run in runs)] for n, joint in enumerate(first.joints)
    ]
    rows.append(["all joints", *(mrad(run.total) for run in runs)])
    header = ["RMS error [mrad]", *(run.label for run in runs)]
    shares = html.note(
        "All joints, relative to the first column: "
        + ", ".join(f"{run.label} {run.total / first.total:.3g}" for run in runs[1:])
        + "."
    )
    shown = html.figure(
        picture,
        "tracking error of each joint over time for each run",
        "Reference position less measured position. The numbers over each plot are RMS errors, in "
        "the order of the legend.",
    )
    column = None if strong is None else strong + 1
    body = html.table(header, rows, strong=column, total=True) + shares + shown
    return Section(title, lead, body)


def tracking_bars_figure(trajectories: Mapping[str, Sequence[Tracking]]) -> Figure:
    """Draw a panel for each trajectory, with the joints side by side and all of them last.

    Args:
        trajectories: by name, the same runs for each.

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
                style: dict[str, Any] = {"ha": "center", "fontsize": 6.5, "color": INK}
                for spot in zip(places, heights, strict=True):
                    said = mrad(1e-3 * spot[1])
                    axes.annotate(said, spot, (0, 2), textcoords="offset points", **style)
            axes.axvline(len(groups) - 1.5, color=FRAME, linewidth=0.8)
            axes.set_xticks(np.arange(len(groups)), groups)
            axes.set_xlim(-0.5, len(groups) - 0.5)
            axes.grid(visible=False, axis="x")
            axes.margins(y=0.12)
            axes.set_ylabel("RMS error [mrad]")
            axes.set_title(name)
        legend_above(figure, *panels[0].get_legend_handles_labels())
    return figure


def tracking_time_figure(runs: Sequence[Tracking]) -> Figure:
    """Draw each joint's error in mrad, the runs over one another in the given order.

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
            axes.set_title(f"{joints[n]}   RMS {_rms(runs, n)} mrad")
            axes.set_ylabel("mrad")
            if n >= len(joints) - columns:
                axes.set_xlabel("time [s]")
                axes.tick_params(labelbottom=True)
        legend_above(figure, *figure.axes[0].get_legend_handles_labels())
    return figure


def _rms(runs: Sequence[Tracking], joint: int) -> str:
    return " → ".join(mrad(float(run.rms[joint])) for run in runs)
