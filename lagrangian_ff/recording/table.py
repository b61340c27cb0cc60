"""Tables of numbers in CSV: a header with the names of columns, then a row of numbers a line."""

import csv
from dataclasses import dataclass
from itertools import count
from pathlib import Path

import numpy as np

from lagrangian_ff import budget
from lagrangian_ff.arrays import Floats, Ints
from lagrangian_ff.errors import UserError
from lagrangian_ff.progress import Progress, silent

_BLOCK = 2 * budget.MIB
"""Characters that are parsed at once; a cell takes 2 of them or more, and 60 bytes meanwhile."""
_SHOWN = 40
"""Characters of a cell or a header that a message shows."""


@dataclass(frozen=True)
class Table:
    """A table of C columns and M rows.

    Attributes:
        names: (C,) of the columns.
        values: (M, C); an empty cell is NaN.
        lines: (M,) the line of the file that each row is from.
    """

    names: list[str]
    values: Floats
    lines: Ints


def read_names(path: Path, error: type[UserError]) -> list[str]:
    """Return the names of the columns; see `read_table`."""
    budget.file_size(path, error)
    with path.open(newline="", encoding="utf-8-sig") as file:
        try:
            header = file.readline(budget.MIB)
            names = [name.strip() for name in next(csv.reader([header]), [])]
        except (UnicodeDecodeError, csv.Error) as why:
            raise error(f"{path}, line 1: not a CSV text file: {_reason(why)}") from why
    if len(header) >= budget.MIB or len(names) > budget.COLUMNS:
        raise error(
            f"{path}, line 1: {len(header)} characters in {len(names)} columns, expected at most "
            f"{budget.MIB} in {budget.COLUMNS}: leave out those that are not needed"
        )
    return names


def read_table(path: Path, error: type[UserError], progress: Progress = silent) -> Table:
    """Return a table with its header.

    Raises:
        UserError: of the given kind, with the line: no text, a cell that is no number, a row that
            does not fit the header, or more columns or characters than `budget` allows.
        OSError: the file cannot be read.
    """
    names = read_names(path, error)
    size = max(1, budget.file_size(path, error))
    blocks, numbers = [np.empty((0, len(names)))], [np.empty(0, dtype=np.int64)]
    with path.open(newline="", encoding="utf-8-sig") as file:
        try:
            file.readline()
            line, done = 2, 0
            while lines := file.readlines(_BLOCK):
                values, at = _parse(path, error, names, lines, line)
                blocks.append(values)
                numbers.append(at)
                line += len(lines)
                done += sum(map(len, lines))
                progress(min(1.0, done / size), f"read {path.name}")
        except (UnicodeDecodeError, csv.Error) as why:
            place = f"{path}, behind line {line - 1}"
            raise error(f"{place}: not a CSV text file: {_reason(why)}") from why
    return Table(names, np.concatenate(blocks), np.concatenate(numbers))


def _reason(why: Exception) -> str:
    return why.reason if isinstance(why, UnicodeDecodeError) else str(why)


def _parse(
    path: Path, error: type[UserError], names: list[str], lines: list[str], first: int
) -> tuple[Floats, Ints]:
    """Return the numbers of these lines, the first of which is line `first` of the file."""
    longest = max(map(len, lines))
    most = budget.CELL * max(10, len(names))
    if longest > most:
        at = next(k for k in count() if len(lines[k]) == longest)
        raise error(
            f"{path}, line {first + at}: {longest} characters, expected at most {most} in "
            f"{len(names)} columns"
        )
    try:
        fast = np.loadtxt(lines, delimiter=",", ndmin=2, comments=None)
        if fast.shape == (len(lines), len(names)):
            return fast, np.arange(first, first + len(lines))
    except ValueError:
        pass  # an empty or a bad cell: the slow way finds it
    rows, numbers = [], []
    reader = csv.reader(lines)
    for cells in reader:
        if not cells:
            continue
        line = first + reader.line_num - 1
        if len(cells) != len(names):
            raise error(f"{path}, line {line}: {len(cells)} cells, the header has {len(names)}")
        rows.append([_number(path, error, line, *pair) for pair in zip(names, cells, strict=True)])
        numbers.append(line)
    values = np.array(rows, dtype=np.float64).reshape(len(rows), len(names))
    return values, np.array(numbers, dtype=np.int64)


def _number(path: Path, error: type[UserError], line: int, name: str, cell: str) -> float:
    try:
        return float(cell) if cell.strip() else np.nan
    except ValueError:
        raise error(
            f"{path}, line {line}: column {name} holds {cell[:_SHOWN]!r}, expected a number"
        ) from None
