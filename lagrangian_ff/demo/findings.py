"""What the demo found, as one record that is printed, shown on the page and written as JSON."""

from dataclasses import dataclass, field, replace
from typing import Any

from lagrangian_ff.demo.arm_link import Pace
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

FAR_BEHIND = 0.1
"""s an arm may be behind the clock without a word being lost about it."""

TARGETS = {"training": 1.0 / 3.0, "unseen": 1.0 / 2.0}
"""How much of the error without feedforward may be left with all of it."""


@dataclass
class Findings:
    """Filled as the demo goes on.

    Attributes:
        options: what was asked for.
        tracking: by trajectory and run.
        pace: by trajectory and run.
        identification: the record of the model.
        comparison: the model held against the motion it never saw, None before.
        seconds: of each stage.
        memory: bytes each process held at most.
        stream: what the feedforward node said of its stream at the end.
    """

    options: Options
    tracking: dict[str, dict[str, Tracking]] = field(default_factory=dict)
    pace: dict[str, dict[str, Pace]] = field(default_factory=dict)
    identification: dict[str, Any] = field(default_factory=dict)
    comparison: Comparison | None = None
    seconds: dict[str, float] = field(default_factory=dict)
    memory: dict[str, int] = field(default_factory=dict)
    stream: dict[str, str] = field(default_factory=dict)

    def keep(self, trajectory: str, run: str, found: Tracking, pace: Pace) -> None:
        """Add a run."""
        self.tracking.setdefault(trajectory, {})[run] = replace(found, label=LABELS[run])
        self.pace.setdefault(trajectory, {})[run] = pace

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
    def behind(self) -> list[str]:
        """The runs in which an arm fell far behind the clock, in words."""
        return [
            f"{pace.behind:.1f} s, {LABELS[run]} on {NAMES[name]}"
            for name, runs in self.pace.items()
            for run, pace in runs.items()
            if pace.behind > FAR_BEHIND
        ]
