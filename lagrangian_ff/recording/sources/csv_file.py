"""CSV with the header `time,position/<joint>,velocity/<joint>,effort/<joint>`.

A column `temperature/<joint>`, °C, may be there for any joint.
"""

import csv
from itertools import islice
from pathlib import Path

import numpy as np

from lagrangian_ff.arrays import Floats
from lagrangian_ff.errors import RecordingError
from lagrangian_ff.progress import Progress
from lagrangian_ff.recording.recording import QUANTITIES, TEMPERATURE, Recording, from_arrays

NAME = "a .csv with the header time,position/<joint>,velocity/<joint>,effort/<joint>"
_BLOCK = 20_000


def recognises(path: Path) -> bool:
    """Return whether its name ends in .csv."""
    return path.suffix.lower() == ".csv"


def read(path: Path, topic: str | None, progress: Progress) -> Recording:
    """Return a table as a recording; empty cells are NaN, `topic` is not used."""
    size = max(1, path.stat().st_size)
    try:
        with path.open(newline="", encoding="utf-8-sig") as file:
            names = [name.strip() for name in next(csv.reader([file.readline()]), [])]
            columns = _columns(path, names)
            blocks = []
            line, done = 2, 0
            while lines := list(islice(file, _BLOCK)):
                blocks.append(_parse(path, names, lines, line))
                line += len(lines)
                done += sum(map(len, lines))
                progress(min(1.0, done / size), f"read {path.name}")
    except UnicodeDecodeError as error:
        raise RecordingError(f"{path}: not a CSV text file: {error.reason}") from error
    table = np.concatenate([np.empty((0, len(names))), *blocks])
    blocks.clear()
    missing: Floats = np.full(len(table), np.nan)
    tables = [
        np.column_stack([table[:, at[name]] if name in at else missing for at in columns.values()])
        for name in (*QUANTITIES, TEMPERATURE)
    ]
    temperature = tables.pop()
    time = table[:, names.index("time")]
    return from_arrays(path, list(columns), time, tables, temperature=temperature)


def write(path: Path, recording: Recording) -> None:
    """Write a table that reads back to the same numbers; only the date of the start is lost."""
    held = recording.tables
    header = ["time", *(f"{kind}/{joint}" for kind in held for joint in recording.joints)]
    with path.open("w", newline="", encoding="utf-8") as file:
        csv.writer(file, lineterminator="\n").writerow(header)
        for first in range(0, len(recording), _BLOCK):
            part = slice(first, first + _BLOCK)
            tables = (held[quantity][part] for quantity in held)
            block = np.column_stack([recording.time[part], *tables])
            rows = (
                ",".join("" if value != value else repr(value) for value in row)
                for row in block.tolist()
            )
            file.write("\n".join(rows) + "\n")


def _columns(path: Path, names: list[str]) -> dict[str, dict[str, int]]:
    """Return the column number by joint and quantity."""
    if "time" not in names:
        raise RecordingError(
            f"{path}, line 1: no column `time`; expected the header "
            f"time,position/<joint>,velocity/<joint>,effort/<joint>, found {','.join(names)[:200]}"
        )
    repeated = sorted({name for name in names if names.count(name) > 1})
    if repeated:
        raise RecordingError(f"{path}, line 1: column given twice: {', '.join(repeated)}")
    columns: dict[str, dict[str, int]] = {}
    for number, name in enumerate(names):
        quantity, _, joint = name.partition("/")
        if quantity in (*QUANTITIES, TEMPERATURE) and joint:
            columns.setdefault(joint, {})[quantity] = number
    without = [joint for joint, found in columns.items() if "position" not in found]
    if not columns or without:
        missing = without[0] if without else "<joint>"
        raise RecordingError(f"{path}, line 1: no column position/{missing}")
    return columns


def _parse(path: Path, names: list[str], lines: list[str], first: int) -> Floats:
    """Return the numbers of these lines, the first of which is line `first` of the file."""
    try:
        fast = np.loadtxt(lines, delimiter=",", ndmin=2, comments=None)
        if fast.shape == (len(lines), len(names)):
            return fast
    except ValueError:
        pass  # an empty or a bad cell: the slow way finds it
    rows = []
    for number, cells in enumerate(csv.reader(lines), start=first):
        if not cells:
            continue
        if len(cells) != len(names):
            raise RecordingError(
                f"{path}, line {number}: {len(cells)} cells, the header has {len(names)}"
            )
        rows.append([_number(path, number, *pair) for pair in zip(names, cells, strict=True)])
    return np.array(rows, dtype=np.float64).reshape(len(rows), len(names))


def _number(path: Path, line: int, name: str, cell: str) -> float:
    try:
        return float(cell) if cell.strip() else np.nan
    except ValueError:
        raise RecordingError(
            f"{path}, line {line}: column {name} holds {cell!r}, expected a number"
        ) from None
