"""Trajectories as CSV: time,position/<joint>,velocity/<joint>,acceleration/<joint>."""

import csv
from pathlib import Path

import numpy as np
import scipy
from numpy.typing import NDArray

from lagrangian_ff.arm.trajectory import Trajectory
from lagrangian_ff.errors import ArmError

Floats = NDArray[np.float64]

COLUMNS = {"q": "position", "qd": "velocity", "qdd": "acceleration", "effort": "effort"}


def write_trajectory(path: str | Path, trajectory: Trajectory) -> None:
    """Write the points, and effort where the trajectory carries it.

    Raises:
        ArmError: the file cannot be written.
    """
    header, table = ["time"], [trajectory.time[:, None]]
    for field, label in COLUMNS.items():
        values = getattr(trajectory, field)
        if values is not None:
            header += [f"{label}/{joint}" for joint in trajectory.joints]
            table.append(values)
    try:
        with Path(path).open("w", newline="", encoding="utf-8") as file:
            writer = csv.writer(file)
            writer.writerow(header)
            writer.writerows(np.hstack(table).tolist())
    except OSError as error:
        raise ArmError(f"{path}: cannot be written: {error.strerror}") from error


def read_trajectory(path: str | Path) -> Trajectory:
    """Read a trajectory; joints are those of the position columns, in their order.

    Missing velocities and accelerations are those of the quintic spline through the positions,
    at rest at both ends; the trajectory's notes say so.

    Raises:
        ArmError: no such file, no time or position, a value that is no number, time that does
            not increase; names file, line and column.
    """
    header, rows = _table(Path(path))
    if "time" not in header:
        raise ArmError(f"{path}: no column 'time'; the header is {', '.join(header)}")
    joints = tuple(c.removeprefix("position/") for c in header if c.startswith("position/"))
    if not joints:
        raise ArmError(f"{path}: no column 'position/<joint>'; the header is {', '.join(header)}")
    time = rows[:, header.index("time")]
    late = np.flatnonzero(~(np.diff(time) > 0))
    if late.size:
        raise ArmError(f"{path}: line {late[0] + 3}: time does not increase at {time[late[0] + 1]}")
    fields: dict[str, Floats | None] = {}
    for field, label in COLUMNS.items():
        names = [f"{label}/{joint}" for joint in joints]
        given = [name for name in names if name in header]
        if given and len(given) < len(names):
            missing = next(name for name in names if name not in header)
            raise ArmError(f"{path}: has {given[0]} but not {missing}: give all joints or none")
        fields[field] = rows[:, [header.index(name) for name in names]] if given else None
    notes = _fill(path, time, fields)
    q, qd, qdd = fields["q"], fields["qd"], fields["qdd"]
    assert q is not None and qd is not None and qdd is not None  # noqa: PT018
    return Trajectory(time, q, qd, qdd, joints, fields["effort"], notes)


def _table(path: Path) -> tuple[list[str], Floats]:
    try:
        with path.open(newline="", encoding="utf-8") as file:
            lines = list(csv.reader(file))
    except FileNotFoundError:
        raise ArmError(f"{path}: no such file") from None
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise ArmError(f"{path}: cannot be read as CSV: {error}") from error
    if len(lines) < 2:
        raise ArmError(f"{path}: expected a header and at least one point")
    header = [column.strip() for column in lines[0]]
    rows = np.empty((len(lines) - 1, len(header)))
    for number, line in enumerate(lines[1:], start=2):
        if len(line) != len(header):
            raise ArmError(f"{path}: line {number}: {len(line)} values, expected {len(header)}")
        for column, text in enumerate(line):
            try:
                rows[number - 2, column] = float(text)
            except ValueError:
                rows[number - 2, column] = np.nan
            if not np.isfinite(rows[number - 2, column]):
                raise ArmError(
                    f"{path}: line {number}: {header[column]} is {text!r}, not a finite number"
                )
    return header, rows


def _fill(path: str | Path, time: Floats, fields: dict[str, Floats | None]) -> tuple[str, ...]:
    missing = [field for field in ("qd", "qdd") if fields[field] is None]
    q = fields["q"]
    assert q is not None
    if not missing:
        return ()
    if len(time) < 2:
        for field in missing:
            fields[field] = np.zeros_like(q)
        return (f"{path}: one point without velocity or acceleration: taken as rest",)
    still = np.zeros(q.shape[1])
    rest = [(1, still), (2, still)]
    spline = scipy.interpolate.make_interp_spline(time, q, k=5, bc_type=(rest, rest))
    for field, order in (("qd", 1), ("qdd", 2)):
        if field in missing:
            fields[field] = spline(time, order)
    words = " and ".join(COLUMNS[field] for field in missing)
    return (f"{path}: {words} filled in from the quintic spline through the positions",)
