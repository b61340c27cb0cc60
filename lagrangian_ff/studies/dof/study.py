"""What a study of error against the number of joints is made of."""

from abc import abstractmethod
from collections.abc import Sequence
from pathlib import Path
from typing import ClassVar

from lagrangian_ff.studies.common.case import Line
from lagrangian_ff.studies.common.study import Numbers, Request, Study
from lagrangian_ff.studies.dof.case import Learning
from lagrangian_ff.studies.dof.numbers import Comparison, numbers_of
from lagrangian_ff.studies.dof.table import table_of
from lagrangian_ff.studies.regression.learn import asked
from lagrangian_ff.studies.robots.samples import Scene

MOST_JOINTS, QUICK_JOINTS = 8, 3
QUICK_ROBOTS = 2


class DofStudy(Study):
    """Models learn random robots of more and more joints.

    Args:
        request: `robots` of each number of joints, and the `models` by their names.
        folder: nothing is kept there.

    Raises:
        UserError: there is no such model.
    """

    takes = frozenset({"robots", "models"})
    robots: ClassVar[int]
    models: ClassVar[tuple[str, ...]]
    quick_models: ClassVar[tuple[str, ...]]
    scene: ClassVar[Scene]
    quick_scene: ClassVar[Scene]
    gamma: ClassVar[float | None]

    def __init__(self, request: Request, folder: Path) -> None:
        super().__init__(request, folder)
        usual = self.quick_models if request.quick else self.models
        self.asked = asked(request.models, usual)

    def every_case(self) -> Sequence[Learning]:
        """See `Study.every_case`: robot by robot, each of every number of joints."""
        quick, seed = self.request.quick, self.request.seed
        scene = self.quick_scene if quick else self.scene
        robots = self.request.robots or (QUICK_ROBOTS if quick else self.robots)
        return [
            Learning(scene, self.gamma, seed, joints, robot, model)
            for robot in range(robots)
            for joints in range(1, (QUICK_JOINTS if quick else MOST_JOINTS) + 1)
            for model in self.asked
        ]

    @abstractmethod
    def comparisons(self, lines: Sequence[Line]) -> list[Comparison]:
        """The paper's claims, and whether the lines bear them out."""

    def numbers(self, lines: Sequence[Line]) -> Numbers:
        """See `numbers_of`."""
        return numbers_of(lines, self.comparisons(lines))

    def table(self, numbers: Numbers) -> list[str]:
        """See `table_of`."""
        return table_of(numbers)
