"""What the demo found, as one record that is printed, shown on the page and written as JSON."""

import os
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from lagrangian_ff.demo.options import Options
from lagrangian_ff.diagnosis import Comparison
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
"""Share of the processors that others take without a word being lost about it."""

SLOW = 0.9
"""Times real time, below which the arm's clock is slow."""

TARGETS = {"training": 1.0 / 3.0, "unseen": 1.0 / 2.0}
"""How much of the error without feedforward may be left with all of it."""


@dataclass
class Findings:
    """Filled as the demo goes on.

    Attributes:
        options: what was asked for.
        tracking: by trajectory and run.
        others: processors that other programs took while the arm was fed with torque.
        speed: times real time that the arm's clock went, by trajectory and run.
        identification: the record of the model.
        comparison: the model held against the motion it never saw, None before.
        seconds: of each stage.
        memory: bytes each process held at most.
        stream: what the feedforward node said of its stream at the end.
    """

    options: Options
    tracking: dict[str, dict[str, Tracking]] = field(default_factory=dict)
    speed: dict[str, dict[str, float]] = field(default_factory=dict)
    others: float = 0.0
    identification: dict[str, Any] = field(default_factory=dict)
    comparison: Comparison | None = None
    seconds: dict[str, float] = field(default_factory=dict)
    memory: dict[str, int] = field(default_factory=dict)
    stream: dict[str, str] = field(default_factory=dict)

    def keep(self, trajectory: str, run: str, found: Tracking, speed: float | None = None) -> None:
        """Add a run, with the speed of the arm's clock where it was a run of the arm node."""
        self.tracking.setdefault(trajectory, {})[run] = replace(found, label=LABELS[run])
        if speed is not None:
            self.speed.setdefault(trajectory, {})[run] = speed

    def runs(self, trajectory: str) -> list[Tracking]:
        """The runs along a trajectory in the order they are shown."""
        return [self.tracking[trajectory][run] for run in LABELS]

    def ratio(self, trajectory: str, run: str = "all") -> float:
        """The error of a run, relative to the one without feedforward."""
        found = self.tracking[trajectory]
        return found[run].total / found["none"].total

    def reached(self, trajectory: str) -> bool:
        """Whether the error with all of the feedforward is as small as it should be."""
        return self.ratio(trajectory) <= TARGETS[trajectory]

    def ordered(self, trajectory: str) -> bool:
        """Whether each part of the feedforward helps: none, without friction, all."""
        found = self.tracking[trajectory]
        return found["none"].total > found["without_friction"].total > found["all"].total

    @property
    def good(self) -> bool:
        """Whether all is as it should be."""
        return all(self.reached(name) and self.ordered(name) for name in TARGETS)

    @property
    def clock(self) -> float:
        """Times real time that the arm's clock went while it was fed with torque.

        The run beside the identification does not count: it shares the machine with our own work.
        """
        return float(
            np.mean(
                [self.speed[name][run] for name in NAMES for run in ("without_friction", "all")]
            )
        )

    @property
    def busy(self) -> str:
        """That the machine is busy, or slow, in words; empty where it is not."""
        processors = os.cpu_count() or 1
        busy = self.others > BUSY * processors
        if not busy and self.clock >= SLOW * min(1.0, self.options.clock_speed):
            return ""
        why = (
            f"busy: others took {self.others:.1f} of its {processors} processors, and" if busy
            else "slow:"
        )  # fmt: skip
        return (
            f"the machine is {why} the arm ran at {self.clock:.2f} of real time; the figures are "
            "not affected"
        )
