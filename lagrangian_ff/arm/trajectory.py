"""Reference motions: quintic splines through points with velocity and acceleration; CSV."""

import csv
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import scipy
from numpy.typing import ArrayLike

from lagrangian_ff import budget
from lagrangian_ff.arm.description import JOINTS, limits
from lagrangian_ff.arrays import Floats, Ints
from lagrangian_ff.errors import ArmError
from lagrangian_ff.recording.table import read_table

# Coefficients of 1, s, ... s⁵ from the values at s = 0 and 1: (q0, v0, a0, q1, v1, a1) in units of
# the segment's duration.
_QUINTIC = np.array(
    [
        [1.0, 0.0, 0.0, 0.0, 0.0, 0.0],
        [0.0, 1.0, 0.0, 0.0, 0.0, 0.0],
        [0.0, 0.0, 0.5, 0.0, 0.0, 0.0],
        [-10.0, -6.0, -1.5, 10.0, -4.0, 0.5],
        [15.0, 8.0, 1.5, -15.0, 7.0, -1.0],
        [-6.0, -3.0, -0.5, 6.0, -3.0, 0.5],
    ]
)
COLUMNS = {"q": "position", "qd": "velocity", "qdd": "acceleration", "effort": "effort"}
"""Columns of a CSV beside time, each followed by /<joint>."""


@dataclass(frozen=True)
class Trajectory:
    """A motion through K points, between them the quintic that meets q, qd and qdd at both ends.

    Attributes:
        time: (K,) s, increasing.
        q: (K, N) rad.  qd: (K, N) rad/s.  qdd: (K, N) rad/s².
        joints: N names.
        effort: (K, N) N·m of feedforward at the points, linear between them; None if none.
        notes: values that the reader filled in, in words.

    Raises:
        ArmError: shapes that do not fit, time that does not increase, a value that is not finite.
    """

    time: Floats
    q: Floats
    qd: Floats
    qdd: Floats
    joints: tuple[str, ...] = JOINTS
    effort: Floats | None = None
    notes: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        for name in ("time", "q", "qd", "qdd", "effort"):
            value = getattr(self, name)
            if value is not None:
                object.__setattr__(self, name, np.asarray(value, dtype=np.float64))
        if self.time.ndim != 1 or len(self.time) < 1:
            raise ArmError(f"trajectory: expected at least one point, got {self.time.shape}")
        shape = (len(self.time), len(self.joints))
        for name in ("q", "qd", "qdd", "effort"):
            value = getattr(self, name)
            if value is None:
                continue
            if value.shape != shape:
                raise ArmError(
                    f"trajectory: {name} has shape {value.shape}, expected {shape} (points, joints)"
                )
            bad = np.argwhere(~np.isfinite(value))
            if bad.size:
                point, joint = bad[0]
                raise ArmError(
                    f"trajectory: {name} of {self.joints[joint]} at {self.time[point]:.3f} s "
                    "is not a finite number"
                )
        late = np.flatnonzero(~(np.diff(self.time) > 0))
        if late.size or not np.all(np.isfinite(self.time)):
            where = self.time[late[0] + 1] if late.size else np.nan
            raise ArmError(f"trajectory: time does not increase at {where:.3f} s")

    def __len__(self) -> int:
        return len(self.time)

    @property
    def duration(self) -> float:
        """Return s from the first point to the last."""
        return float(self.time[-1] - self.time[0])

    def sample(self, time: ArrayLike) -> tuple[Floats, Floats, Floats]:
        """Return q, qd and qdd at these times: (..., N) each.

        Before the first point and after the last the arm rests there.
        """
        at = np.asarray(time, dtype=np.float64)
        if len(self) == 1:
            still = np.zeros((*at.shape, len(self.joints)))
            return still + self.q[0], still, still.copy()
        flat = at.reshape(-1)
        k = np.clip(np.searchsorted(self.time, flat, side="right") - 1, 0, len(self) - 2)
        span = (self.time[k + 1] - self.time[k])[:, None]
        s = np.clip((flat - self.time[k])[:, None] / span, 0.0, 1.0)
        ends = np.stack(
            [
                np.zeros_like(self.q[k]),
                self.qd[k] * span,
                self.qdd[k] * span**2,
                self.q[k + 1] - self.q[k],
                self.qd[k + 1] * span,
                self.qdd[k + 1] * span**2,
            ]
        )
        c = np.tensordot(_QUINTIC, ends, axes=1)
        q = self.q[k] + s * (c[1] + s * (c[2] + s * (c[3] + s * (c[4] + s * c[5]))))
        qd = c[1] + s * (2 * c[2] + s * (3 * c[3] + s * (4 * c[4] + s * 5 * c[5])))
        qdd = 2 * c[2] + s * (6 * c[3] + s * (12 * c[4] + s * 20 * c[5]))
        moving = ((flat >= self.time[0]) & (flat <= self.time[-1]))[:, None]
        shape = (*at.shape, len(self.joints))
        return (
            q.reshape(shape),
            (qd / span * moving).reshape(shape),
            (qdd / span**2 * moving).reshape(shape),
        )

    def effort_at(self, time: ArrayLike) -> Floats:
        """Return feedforward torque (..., N) N·m at these times, constant outside the ends.

        Raises:
            ArmError: the trajectory carries none.
        """
        if self.effort is None:
            raise ArmError("the trajectory carries no effort: compute a feedforward for it first")
        at = np.asarray(time, dtype=np.float64)
        columns = [np.interp(at, self.time, column) for column in self.effort.T]
        return np.stack(columns, axis=-1)

    def select(self, joints: Sequence[str]) -> "Trajectory":
        """Return the trajectory of these joints, in this order.

        Raises:
            ArmError: a joint is not in the trajectory; names both lists.
        """
        missing = [name for name in joints if name not in self.joints]
        if missing:
            raise ArmError(
                f"trajectory: no joint {', '.join(missing)}; it moves {', '.join(self.joints)}"
            )
        columns = [self.joints.index(name) for name in joints]
        effort = None if self.effort is None else self.effort[:, columns]
        motion = {name: getattr(self, name)[:, columns] for name in ("q", "qd", "qdd")}
        return replace(self, **motion, joints=tuple(joints), effort=effort)


def check_limits(trajectory: Trajectory) -> None:
    """Require that position and velocity at the points of an arm's trajectory are within limits.

    Raises:
        ArmError: they are not; names the first joint and time.
    """
    bounds = limits()
    slack = 1e-6
    for what, unit, value, low, high in (
        ("position", "rad", trajectory.q, bounds.lower, bounds.upper),
        ("velocity", "rad/s", trajectory.qd, -bounds.velocity, bounds.velocity),
    ):
        bad = np.argwhere((value < low - slack) | (value > high + slack))
        if bad.size:
            point, n = bad[0]
            raise ArmError(
                f"trajectory: {what} of {JOINTS[n]} at {trajectory.time[point]:.3f} s is "
                f"{value[point, n]:.3f} {unit}, outside {low[n]:.3f} to {high[n]:.3f} {unit}"
            )


def write_trajectory(path: str | Path, trajectory: Trajectory) -> None:
    """Write the points, and effort if the trajectory has it.

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
    """Return the trajectory in a file; joints are those of the position columns, in their order.

    Missing velocities and accelerations are those of the quintic spline through the positions,
    at rest at both ends; the trajectory's notes say so.

    Raises:
        ArmError: no such file, no time or position, a value that is no number, time that does
            not increase; names file, line and column.
    """
    header, rows, lines = _table(Path(path))
    if "time" not in header:
        raise ArmError(f"{path}: no column 'time'; the header is {', '.join(header)[:200]}")
    joints = tuple(c.removeprefix("position/") for c in header if c.startswith("position/"))
    if not joints:
        raise ArmError(
            f"{path}: no column 'position/<joint>'; the header is {', '.join(header)[:200]}"
        )
    time = rows[:, header["time"]]
    late = np.flatnonzero(~(np.diff(time) > 0))
    if late.size:
        line, at = lines[late[0] + 1], time[late[0] + 1]
        raise ArmError(f"{path}: line {line}: time does not increase at {at}")
    fields: dict[str, Floats | None] = {}
    for field, label in COLUMNS.items():
        names = [f"{label}/{joint}" for joint in joints]
        given = [name for name in names if name in header]
        if given and len(given) < len(names):
            missing = next(name for name in names if name not in header)
            raise ArmError(f"{path}: has {given[0]} but not {missing}: give all joints or none")
        fields[field] = rows[:, [header[name] for name in names]] if given else None
    notes = _fill(path, time, fields)
    q, qd, qdd = fields["q"], fields["qd"], fields["qdd"]
    assert q is not None and qd is not None and qdd is not None  # noqa: PT018
    try:
        return Trajectory(time, q, qd, qdd, joints, fields["effort"], notes)
    except ArmError as error:
        raise ArmError(f"{path}: {error}") from error


def _table(path: Path) -> tuple[dict[str, int], Floats, Ints]:
    """Return the columns' numbers by name, the values, all finite, and the line of each row."""
    try:
        table = read_table(path, ArmError)
    except FileNotFoundError:
        raise ArmError(f"{path}: no such file") from None
    except (OSError, MemoryError) as error:
        raise ArmError(f"{path}: cannot be read: {error}") from error
    if not len(table.values):
        raise ArmError(f"{path}: expected a header and at least one point")
    bad = np.argwhere(~(np.abs(table.values) <= budget.LARGEST))
    if bad.size:
        row, column = bad[0]
        raise ArmError(
            f"{path}: line {table.lines[row]}: {table.names[column]} is "
            f"{table.values[row, column]:g}, expected a number up to {budget.LARGEST:g}"
        )
    header = {name: column for column, name in enumerate(table.names)}
    if len(header) < len(table.names):
        raise ArmError(f"{path}: line 1: a column is given twice")
    return header, table.values, table.lines


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
    try:
        with np.errstate(all="ignore"):
            spline = scipy.interpolate.make_interp_spline(time, q, k=5, bc_type=(rest, rest))
            found = {field: spline(time, order) for field, order in (("qd", 1), ("qdd", 2))}
    except ValueError as error:
        raise ArmError(
            f"{path}: no spline goes through the positions ({error}): check their times, or give "
            "velocity and acceleration"
        ) from error
    fields.update((field, found[field]) for field in missing)
    words = " and ".join(COLUMNS[field] for field in missing)
    return (f"{path}: {words} filled in from the quintic spline through the positions",)
