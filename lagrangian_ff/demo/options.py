"""The options of the demo."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from lagrangian_ff.errors import UserError
from lagrangian_ff.identification.settings import Settings

THROUGH = ("stream", "trajectory")


@dataclass(frozen=True)
class Options:
    """The demo's settings.

    Attributes:
        output: folder of the results; made if it is missing.
        speed: 1 to 10, of both trajectories.
        seed: of the trajectory that is learned from; the one never seen has the next.
        duration: s of the trajectory that is learned from.
        unseen_duration: s of the other one.
        model: kernel and effects to identify.
        samples: number of samples the kernel is built on.
        train: share of the recording that is learned from, from its beginning.
        through: the torque's way to the arm: "stream", torque by torque while it moves, or
            "trajectory", with the points of the trajectory before it moves.
        clock_speed: of the arm's clock, times real time, if the machine keeps up.
        domain: ROS domain to use; None looks for an unused one.
    """

    output: Path = Path("out")
    speed: int = 5
    seed: int = 0
    duration: float = 24.0
    unseen_duration: float = 16.0
    model: str = Settings.model
    samples: int = 1000
    train: float = 1.0
    through: str = "stream"
    clock_speed: float = 2.0
    domain: int | None = None

    def __post_init__(self) -> None:
        for name, low, high in (
            ("duration", 8.0, 600.0),
            ("unseen_duration", 4.0, 600.0),
            ("train", 0.05, 1.0),
            ("samples", 10, 5000),
            ("speed", 1, 10),
            ("clock_speed", 0.1, 100.0),
        ):
            value = getattr(self, name)
            if not low <= value <= high:
                raise UserError(f"{name} is {value}, expected {low:g} to {high:g}")
        if self.through not in THROUGH:
            raise UserError(f"through is '{self.through}', expected {' or '.join(THROUGH)}")
        if self.domain is not None and not 0 <= self.domain <= 101:
            raise UserError(f"domain is {self.domain}, expected 0 to 101")


QUICK: dict[str, Any] = {
    "duration": 8.0,
    "unseen_duration": 5.0,
    "samples": 300,
    "model": "chain+fri",
}
"""Short motions, to see everything work in a minute."""
