"""What a study is: its cases, and what their lines come to."""

import fnmatch
from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar

from matplotlib.figure import Figure

from lagrangian_ff import __version__
from lagrangian_ff.errors import UserError
from lagrangian_ff.studies.common.case import Case, Line

OPTIONS = ("robots", "models", "keep")
Numbers = dict[str, Any]


@dataclass(frozen=True)
class Request:
    """What is asked of a study.

    Attributes:
        seed: of all that chance decides.
        quick: a small study, to see it work.
        only: a pattern with * and ? that the names of the cases must match.
        robots: how many of each kind; None is the study's own number.
        models: the models compared, by their names; empty is the study's own list.
        keep: keep what cases record, and use what was kept.
    """

    seed: int = 0
    quick: bool = False
    only: str = "*"
    robots: int | None = None
    models: tuple[str, ...] = ()
    keep: bool = False


class Study(ABC):
    """One study. Nothing is computed before `Case.run`.

    Args:
        request: what is asked.
        folder: where cases may keep what they record.

    Raises:
        UserError: something is asked that the study does not have.
    """

    name: ClassVar[str]
    takes: ClassVar[frozenset[str]] = frozenset()
    """Which of `robots`, `models` and `keep` can be asked."""

    def __init__(self, request: Request, folder: Path) -> None:
        for option in OPTIONS:
            if getattr(request, option) and option not in self.takes:
                raise UserError(f"study {self.name} has no --{option}")
        if request.robots is not None and request.robots < 1:
            raise UserError(f"--robots is {request.robots}, expected at least 1")
        self.request = request
        self.folder = folder

    def identity(self) -> dict[str, Any]:
        """What makes two studies the same: a folder goes on with one of the same only."""
        return {
            "study": self.name,
            "version": __version__,
            "seed": self.request.seed,
            "quick": self.request.quick,
        }

    @abstractmethod
    def every_case(self) -> Sequence[Case]:
        """All cases, the most telling first: a study stopped early has something of everything.

        A case stays what it is, under its name, when others join.
        """

    def cases(self) -> list[Case]:
        """The cases asked for.

        Raises:
            UserError: none has such a name.
        """
        every = self.every_case()
        found = [case for case in every if fnmatch.fnmatchcase(case.name, self.request.only)]
        if not found:
            raise UserError(
                f"no case is named {self.request.only!r}; there are {len(every)}, such as "
                f"{every[0].name} and {every[-1].name}"
            )
        return found

    @abstractmethod
    def numbers(self, lines: Sequence[Line]) -> Numbers:
        """What the lines come to, for JSON; of some of the lines too."""

    @abstractmethod
    def table(self, numbers: Numbers) -> list[str]:
        """The numbers in words."""

    @abstractmethod
    def figure(self, numbers: Numbers) -> Figure:
        """The numbers as a picture."""


def failures(lines: Sequence[Line]) -> Mapping[str, str]:
    """Why cases failed, by their names."""
    return {line["case"]: line["failed"] for line in lines if "failed" in line}


def failures_told(failed: Mapping[str, str]) -> list[str]:
    """The failures as lines of text, after an empty one; nothing where there are none."""
    if not failed:
        return []
    return ["", "failed:", *(f"  {case}: {why}" for case, why in failed.items())]
