"""The results of the demo, and how they are printed; `page` shows them."""

import os
from dataclasses import asdict, dataclass, field, replace
from typing import Any

import numpy as np
from rich.console import Console
from rich.table import Table

from lagrangian_ff import __version__
from lagrangian_ff.demo.folder import Folder
from lagrangian_ff.demo.options import Options
from lagrangian_ff.diagnosis import Comparison
from lagrangian_ff.identification.records import Identified
from lagrangian_ff.numbers import mrad, percent, typeset
from lagrangian_ff.report import Tracking

LABELS = {
    "none": "no feedforward",
    "without_friction": "without friction",
    "all": "with friction",
    "bound": "true torque (bound)",
}
"""The runs along each trajectory, in the order they are shown."""

NAMES = {"training": "the motion it learned from", "unseen": "a motion it never saw"}
"""The trajectories, in the order they are shown."""

BUSY = 0.2
"""Share of the processors that others may take without a note."""

SLOW = 0.9
"""Times real time, below which the arm's clock is slow."""

TARGETS = {"training": 1.0 / 3.0, "unseen": 1.0 / 2.0}
"""Share of the error without feedforward that may be left with all of it."""


@dataclass
class Findings:
    """The results, filled in as the demo goes on.

    Attributes:
        options: what was asked for.
        tracking: by trajectory and run.
        others: processors that other programs took while the arm was fed with torque.
        speed: times real time that the arm's clock went, by trajectory and run.
        identification: of the model.
        comparison: of the model with the motion it never saw; None before.
        seconds: of each stage.
        memory: the most that each process held, bytes.
        stream: the feedforward node's last status of its stream.
    """

    options: Options
    tracking: dict[str, dict[str, Tracking]] = field(default_factory=dict)
    speed: dict[str, dict[str, float]] = field(default_factory=dict)
    others: float = 0.0
    identification: Identified = field(default_factory=Identified)
    comparison: Comparison | None = None
    seconds: dict[str, float] = field(default_factory=dict)
    memory: dict[str, int] = field(default_factory=dict)
    stream: dict[str, str] = field(default_factory=dict)

    def keep(self, trajectory: str, run: str, found: Tracking, speed: float | None = None) -> None:
        """Add a run, with the speed of the arm's clock if the arm node made it."""
        self.tracking.setdefault(trajectory, {})[run] = replace(found, label=LABELS[run])
        if speed is not None:
            self.speed.setdefault(trajectory, {})[run] = speed

    def runs(self, trajectory: str) -> list[Tracking]:
        """Return the runs along a trajectory in the order they are shown."""
        return [self.tracking[trajectory][run] for run in LABELS]

    def ratio(self, trajectory: str, run: str = "all") -> float:
        """Return the error of a run, relative to the one without feedforward."""
        found = self.tracking[trajectory]
        return found[run].total / found["none"].total

    def reached(self, trajectory: str) -> bool:
        """Return whether the error with all of the feedforward is within its target."""
        return self.ratio(trajectory) <= TARGETS[trajectory]

    def ordered(self, trajectory: str) -> bool:
        """Return whether each part of the feedforward helps: none, without friction, all."""
        found = self.tracking[trajectory]
        return found["none"].total > found["without_friction"].total > found["all"].total

    @property
    def good(self) -> bool:
        """Return whether both motions reach their target and order."""
        return all(self.reached(name) and self.ordered(name) for name in TARGETS)

    @property
    def clock(self) -> float:
        """Return the speed of the arm's clock, times real time, while it was fed with torque.

        The run during identification does not count: it shares the machine with our own work.
        """
        fed = "without_friction", "all"
        return float(np.mean([self.speed[name][run] for name in NAMES for run in fed]))

    @property
    def busy(self) -> str:
        """Return a sentence if the machine is busy or slow, else nothing."""
        processors = os.cpu_count() or 1
        busy = self.others > BUSY * processors
        if not busy and self.clock >= SLOW * min(1.0, self.options.clock_speed):
            return ""
        others = f"busy: others took {self.others:.1f} of its {processors} processors, and"
        return (
            f"the machine is {others if busy else 'slow:'} the arm ran at {self.clock:.2f} of real "
            "time; the figures are not affected"
        )

    def record(self) -> dict[str, Any]:
        """Return all numbers for JSON; angles in rad, torques in N·m, memory in bytes."""
        assert self.comparison is not None
        options = {**asdict(self.options), "output": str(self.options.output)}
        return {
            "version": __version__,
            "options": options,
            "reached": self.good,
            "tracking": {
                name: {
                    "runs": {
                        run: {**found[run].record(), "clock_speed": self.speed[name].get(run)}
                        for run in LABELS
                    },
                    "ratio": self.ratio(name),
                    "ratio_without_friction": self.ratio(name, "without_friction"),
                    "ratio_bound": self.ratio(name, "bound"),
                    "target": TARGETS[name],
                    "reached": self.reached(name),
                    "ordered": self.ordered(name),
                }
                for name, found in self.tracking.items()
            },
            "torque": self.comparison.record(),
            "identification": self.identification.record(),
            "seconds": {name: round(took, 2) for name, took in self.seconds.items()},
            "memory": self.memory,
            "stream": self.stream,
            "clock_speed": self.clock,
            "processors_of_others": self.others,
            "busy": self.busy,
        }


def print_findings(findings: Findings, folder: Folder, console: Console) -> None:
    """Print tables and verdict."""
    console.print()
    console.print(_torque_table(findings))
    for name in NAMES:
        console.print(_tracking_table(findings, name))
    for name in NAMES:
        console.print(_verdict(findings, name), highlight=False)
    if findings.busy:
        console.print(f"[yellow]note:[/] {findings.busy}", highlight=False)
    console.print(f"\nLook at it: [bold]{folder.page}[/]", highlight=False, soft_wrap=True)
    rest = f"recordings {folder.bag()} and {folder.unseen}, all numbers {folder.record}"
    console.print(f"Model {folder.model}, {rest}", highlight=False, soft_wrap=True)


def _torque_table(findings: Findings) -> Table:
    assert findings.comparison is not None
    score, spread = findings.comparison.score, findings.comparison.motion.tau.std(axis=0)
    title = f"Torque predicted by {findings.options.model} on {NAMES['unseen']}"
    table = Table(title=title, title_justify="left")
    for column in ("joint", "spread [N·m]", "RMS error [N·m]", "error / spread", "nMSE"):
        table.add_column(column, justify="left" if column == "joint" else "right")
    figures = (each.tolist() for each in (spread, score.rmse, score.rmse / spread, score.nmse))
    for joint, moved, error, share, nmse in zip(score.joints, *figures, strict=True):
        table.add_row(joint, typeset(moved), typeset(error), percent(share), typeset(nmse))
    return table


def _tracking_table(findings: Findings, name: str) -> Table:
    runs = findings.runs(name)
    title = f"RMS tracking error in mrad on {NAMES[name]}"
    table = Table(title=title, title_justify="left", show_footer=True)
    table.add_column("joint", footer="all joints\nratio")
    for run, tracking in zip(LABELS, runs, strict=True):
        footer = f"{mrad(tracking.total)}\n{findings.ratio(name, run):.3f}"
        table.add_column(LABELS[run], footer=footer, justify="right")
    for n, joint in enumerate(runs[0].joints):
        table.add_row(joint, *(mrad(float(tracking.rms[n])) for tracking in runs))
    return table


def _verdict(findings: Findings, name: str) -> str:
    ratio, target = findings.ratio(name), TARGETS[name]
    order = "none > without friction > with friction"
    met = findings.reached(name), findings.ordered(name)
    reached, ordered = ("[green]✓[/]" if one else "[red]✗[/]" for one in met)
    return (
        f"{reached} on {NAMES[name]} the error falls to {percent(ratio)} (target: at most "
        f"{percent(target)})   {ordered} {order}"
    )
