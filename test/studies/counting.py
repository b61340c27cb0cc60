"""A study that counts: quick to do, and seen to be done."""

import os
import signal
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from matplotlib.figure import Figure

from lagrangian_ff.studies.study import Line, Results, Study


@dataclass(frozen=True)
class Square:
    """The square of a number; every try leaves a file.

    Attributes:
        number: below 0 the case breaks down.
        folder: where tries are counted.
        deadly: the first try kills its process.
    """

    number: int
    folder: Path
    deadly: bool = False

    @property
    def name(self) -> str:
        return f"square-{self.number}"

    def tries(self) -> int:
        return len(list(self.folder.glob(f"{self.name}-*")))

    def run(self) -> Mapping[str, Any]:
        (self.folder / f"{self.name}-{time.monotonic_ns()}").touch()
        if self.deadly and self.tries() == 1:
            os.kill(os.getpid(), signal.SIGKILL)
        if self.number < 0:
            raise ValueError("negative")
        return {"square": self.number**2, "process": os.getpid()}


class Squares(Study):
    """Squares of 0 to 3."""

    name = "squares"
    takes = frozenset({"robots"})

    def every_case(self) -> Sequence[Square]:
        return [Square(number, self.folder) for number in range(4)]

    def results(self, lines: Sequence[Line]) -> "Sum":
        return Sum(lines, None, sum(line["square"] for line in lines))


@dataclass(frozen=True)
class Sum(Results):
    """The sum of the squares."""

    sum: int

    def numbers(self) -> dict[str, Any]:
        return {"sum": self.sum}

    def text(self) -> list[str]:
        return [f"sum {self.sum}"]

    def figure(self) -> Figure:
        return Figure()
