"""CSV with the header `time,position/<joint>,velocity/<joint>,effort/<joint>`.

A column `temperature/<joint>`, °C, may be there for any joint.
"""

import csv
from collections import Counter
from pathlib import Path

import numpy as np

from lagrangian_ff.arrays import Floats
from lagrangian_ff.errors import RecordingError
from lagrangian_ff.progress import Progress
from lagrangian_ff.recording.recording import (
    QUANTITIES,
    TEMPERATURE,
    Recording,
    from_arrays,
    require_joints,
)
from lagrangian_ff.recording.table import read_names, read_table

NAME = "a .csv with the header time,position/<joint>,velocity/<joint>,effort/<joint>"
_BLOCK = 20_000


def recognises(path: Path) -> bool:
    """Return whether its name ends in .csv."""
    return path.suffix.lower() == ".csv"


def read(path: Path, topic: str | None, progress: Progress) -> Recording:
    """Return a table as a recording; empty cells are NaN, `topic` is not used."""
    names = read_names(path, RecordingError)
    columns = _columns(path, names)
    table = read_table(path, RecordingError, progress).values
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
    repeated = sorted(name for name, times in Counter(names).items() if times > 1)
    if repeated:
        raise RecordingError(f"{path}, line 1: column given twice: {', '.join(repeated)[:200]}")
    columns: dict[str, dict[str, int]] = {}
    for number, name in enumerate(names):
        quantity, _, joint = name.partition("/")
        if quantity in (*QUANTITIES, TEMPERATURE) and joint:
            columns.setdefault(joint, {})[quantity] = number
    without = [joint for joint, found in columns.items() if "position" not in found]
    if not columns or without:
        missing = without[0] if without else "<joint>"
        raise RecordingError(f"{path}, line 1: no column position/{missing}")
    require_joints(f"{path}, line 1", len(columns))
    return columns
