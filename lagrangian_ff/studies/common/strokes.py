"""How kernels are drawn, the same in every study."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from lagrangian_ff.report.colours import FAINT, INK, RUNS

GREY, AMBER, BLUE, GREEN, VIOLET, RED = RUNS
SOLID, DASHED, DOTTED = "-", (0, (4, 2)), (0, (1, 1.5))


@dataclass(frozen=True)
class Stroke:
    """How a kernel is drawn, whatever it is joined with.

    Attributes:
        colour: of the family.  dashes: solid where positions are angles, by (39).
        ours: not of the paper.
    """

    colour: str
    dashes: Any = SOLID
    ours: bool = False


STROKES: Mapping[str, Stroke] = {
    "motor": Stroke(FAINT, DOTTED),
    "rbf": Stroke(GREY, DASHED),
    "rbfs": Stroke(GREY),
    "srbf": Stroke(AMBER, DASHED),
    "srbfs": Stroke(AMBER),
    "svrbf": Stroke(AMBER, (0, (4, 1.5, 1, 1.5))),
    "svrbfs": Stroke(AMBER, DOTTED),
    "vrbf": Stroke(BLUE, DASHED),
    "vrbfs": Stroke(BLUE),
    "pol": Stroke(INK, DOTTED),
    "energy_rbf": Stroke(GREEN, DASHED, ours=True),
    "energy": Stroke(GREEN, ours=True),
    "chain_rbf": Stroke(VIOLET, DASHED, ours=True),
    "chain": Stroke(VIOLET, ours=True),
    "auto": Stroke(RED, ours=True),
}
OTHER = Stroke(INK)


def stroke_of(model: str) -> Stroke:
    """Of the kernel of a model."""
    return STROKES.get(model.partition("+")[0], OTHER)
