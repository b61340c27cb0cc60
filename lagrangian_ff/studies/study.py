"""The parts of every study: a request, independent cases, and results of their lines."""

import fnmatch
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar, Protocol, TypeVar

from matplotlib.figure import Figure

from lagrangian_ff import __version__
from lagrangian_ff.errors import UserError

OPTIONS = {
    "robots": "--robots",
    "models": "--models",
    "keep": "--keep",
    "recordings": "folder of recordings",
    "known": "--known",
}
"""Attributes of a request that not every study takes, and how the user gives them."""
CELL = 9  # characters of a cell in a table

Line = dict[str, Any]
"""A case in `cases.jsonl`: `case`, what it found, and `seconds`; or `case` and `failed`."""


class Case(Protocol):
    """The smallest piece of a study.

    It depends on no other and can be pickled, so that any process on any machine can do it.
    """

    @property
    def name(self) -> str:
        """Return a name that is unique in the study."""

    def run(self) -> Mapping[str, Any]:
        """Do the case and return what it found, the same on every machine."""


AnyCase = TypeVar("AnyCase", bound=Case)


@dataclass(frozen=True)
class Request:
    """A request for a study.

    Attributes:
        seed: of all random numbers.
        quick: a small study, to see it work.
        only: a pattern with * and ? that the names of the cases must match.
        robots: number of robots of each kind; None is the study's own number.
        models: the models to compare, by their names; empty is the study's own list.
        keep: keep what cases record, and use what was kept.
        recordings: the folder of measured recordings.
        known: the folder of files that say what is known of them; None looks beside them.
    """

    seed: int = 0
    quick: bool = False
    only: str = "*"
    robots: int | None = None
    models: tuple[str, ...] = ()
    keep: bool = False
    recordings: Path | None = None
    known: Path | None = None


@dataclass(frozen=True)
class Finding:
    """A claim, and whether it holds.

    Attributes:
        holds: whether the results bear it out.
        says: the claim with its figures, in a sentence.
        figures: the figures of that sentence by name, as JSON holds them.
    """

    holds: bool
    says: str
    figures: Mapping[str, Any]

    def record(self) -> dict[str, Any]:
        """Return the finding as JSON holds it."""
        return {"holds": bool(self.holds), "says": self.says, **self.figures}


@dataclass(frozen=True)
class Results(ABC):
    """The results of the lines of a study.

    Attributes:
        lines: all or some of the study's.
        findings: claims by name; None in a study that makes none.
    """

    lines: Sequence[Line]
    findings: Mapping[str, Finding] | None

    @property
    def failed(self) -> dict[str, str]:
        """Return why cases failed, by their names."""
        return {line["case"]: line["failed"] for line in self.lines if "failed" in line}

    def record(self) -> dict[str, Any]:
        """Return the results as `summary.json` holds them."""
        found = {"cases": len(self.lines), "failed": self.failed, **self.numbers()}
        if self.findings is not None:
            found["findings"] = {name: each.record() for name, each in self.findings.items()}
        return found

    def table(self) -> list[str]:
        """Return the results as lines of text."""
        text = self.text()
        if self.findings:
            text.append("")
            for each in self.findings.values():
                text.append(f"{'yes' if each.holds else 'NO':<4} {each.says}")
        if self.failed:
            text += ["", "failed:", *(f"  {case}: {why}" for case, why in self.failed.items())]
        return text

    @abstractmethod
    def numbers(self) -> dict[str, Any]:
        """Return the numbers of the table and the figure, as JSON holds them."""

    @abstractmethod
    def text(self) -> list[str]:
        """Return the numbers as lines of text."""

    @abstractmethod
    def figure(self) -> Figure:
        """Draw the numbers."""


class Study(ABC):
    """One study. Nothing is computed before `Case.run`.

    Args:
        request: what the user asks.
        folder: where cases may keep what they record.

    Raises:
        UserError: the request has an option that the study does not take.
    """

    name: ClassVar[str]
    takes: ClassVar[frozenset[str]] = frozenset()
    """Those of `OPTIONS` that the study takes."""

    def __init__(self, request: Request, folder: Path) -> None:
        for option, given in OPTIONS.items():
            if getattr(request, option) and option not in self.takes:
                raise UserError(f"study {self.name} has no {given}")
        if request.robots is not None and request.robots < 1:
            raise UserError(f"--robots is {request.robots}, expected at least 1")
        self.request = request
        self.folder = folder

    def identity(self) -> dict[str, Any]:
        """Return what identifies the study: a folder goes on with no other."""
        return {
            "study": self.name,
            "version": __version__,
            "seed": self.request.seed,
            "quick": self.request.quick,
        }

    def recorders(self) -> list[Case]:
        """Return for each case that the request names what only makes and keeps its recordings.

        Raises:
            UserError: no case matches, or the study makes no recordings.
        """
        raise UserError(f"study {self.name} has no --record")

    def current(self, line: Line) -> bool:
        """Return whether a line that did not fail is still that of its case."""
        return True

    @abstractmethod
    def every_case(self) -> Sequence[Case]:
        """Return all cases, the most telling first: a study stopped early has some of each kind.

        A case stays the same, under its name, when others join.
        """

    def cases(self) -> list[Case]:
        """Return the cases that the request names; raise UserError if there are none."""
        return self.named(self.every_case())

    def named(self, every: Sequence[AnyCase]) -> list[AnyCase]:
        """Return those of some cases that the request names; raise UserError if there are none."""
        found = [case for case in every if fnmatch.fnmatchcase(case.name, self.request.only)]
        if not found:
            raise UserError(
                f"no case is named {self.request.only!r}; there are {len(every)}, such as "
                f"{every[0].name} and {every[-1].name}"
            )
        return found

    @abstractmethod
    def results(self, lines: Sequence[Line]) -> Results:
        """Return the results of all or some of the lines."""


def done(lines: Iterable[Line]) -> list[Line]:
    """Return the lines of the cases that did not fail."""
    return [line for line in lines if "failed" not in line]


def grouped(lines: Iterable[Line], field: str) -> dict[Any, list[Line]]:
    """Return the lines that have the same value in a field, by that value."""
    found: dict[Any, list[Line]] = {}
    for line in lines:
        found.setdefault(line[field], []).append(line)
    return found


def shown(findings: Mapping[str, Finding | None]) -> dict[str, Finding]:
    """Return the findings for which enough cases are done."""
    return {name: finding for name, finding in findings.items() if finding}


def row(name: str, cells: Iterable[str], first: int, width: int = CELL) -> str:
    """Return a row of a table: a name in `first` characters, and cells of `width`."""
    return (f"  {name:<{first}}" + "".join(f"{cell:>{width}}" for cell in cells)).rstrip()


def cells(
    columns: Iterable[Any], values: Mapping[Any, float], written: Callable[[float], str]
) -> list[str]:
    """Return the values of a row as text, a dash in each column without one."""
    return [written(values[column]) if column in values else "-" for column in columns]
