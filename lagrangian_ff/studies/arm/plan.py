"""How much a study drives and learns: as in section IV-B of the paper, or little."""

from dataclasses import dataclass

from lagrangian_ff.arm.exciting import SPEEDS
from lagrangian_ff.identification import Settings


@dataclass(frozen=True)
class Plan:
    """The trajectories of a study, and how models are identified from them.

    The first third of 30 to 40 s holds three or four blocks of 3 s, fewer than the paper's five
    folds: each is then left out by itself.

    Attributes:
        speeds: of the exciting trajectories, rising.
        seconds: length of each; None is 30 to 40 s.
        settings: of every identification but for the model: learned from the first third.
    """

    speeds: tuple[int, ...]
    seconds: float | None
    settings: Settings

    @classmethod
    def of(cls, *, quick: bool) -> "Plan":
        """The paper's, or a small one to see a study work."""
        return QUICK if quick else FULL


FULL = Plan(
    tuple(SPEEDS),
    None,
    Settings(train=1 / 3, samples=500, block_seconds=3.0, folds=5, selection="validation"),
)
QUICK = Plan(
    (2, 5, 9),
    9.0,
    Settings(
        train=1 / 3, samples=60, block_seconds=1.0, folds=3, selection="validation", evaluations=6
    ),
)
