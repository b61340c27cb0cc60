"""The two motions of the demo."""

from dataclasses import dataclass

from lagrangian_ff.arm import Trajectory, exciting_trajectory
from lagrangian_ff.demo.options import Options


@dataclass(frozen=True)
class Motions:
    """Both begin and end at rest at the arm's home position.

    Attributes:
        training: what the model is learned from.
        unseen: what it never saw.
    """

    training: Trajectory
    unseen: Trajectory

    def named(self) -> dict[str, Trajectory]:
        """By name."""
        return {"training": self.training, "unseen": self.unseen}


def make_motions(options: Options) -> Motions:
    """Exciting trajectories of two seeds.

    Raises:
        ArmError: none was found within the arm's limits.
    """
    return Motions(
        exciting_trajectory(options.speed, options.seed, options.duration),
        exciting_trajectory(options.speed, options.seed + 1, options.unseen_duration),
    )
