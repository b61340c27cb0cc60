"""The motion to follow: points in time, complete with velocities and accelerations."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import chain

import numpy as np
import scipy
from numpy.typing import NDArray

from lagrangian_ff.nodes.common.errors import RefusedReference

Floats = NDArray[np.float64]

# d^r/dt^r of t^k is FACTOR[r, k] t^EXPONENT[r, k].
EXPONENT = np.array([[0, 1, 2, 3, 4, 5], [0, 0, 1, 2, 3, 4], [0, 0, 0, 1, 2, 3]])
FACTOR = np.array([[1.0, 1, 1, 1, 1, 1], [0, 1, 2, 3, 4, 5], [0, 0, 2, 6, 12, 20]])


@dataclass(frozen=True)
class Points:
    """A trajectory as it came in a message: rows may be empty or of the wrong length.

    Attributes:
        names: joints in the order of the columns.
        time: K times from the start, s.
        position: K rows; velocity, acceleration, effort: K rows, empty where not given.
    """

    names: Sequence[str]
    time: Sequence[float]
    position: Sequence[Sequence[float]]
    velocity: Sequence[Sequence[float]]
    acceleration: Sequence[Sequence[float]]
    effort: Sequence[Sequence[float]] = ()


@dataclass(frozen=True)
class Reference:
    """Where N joints shall be at K times.

    Between two points the motion is the 5th-order polynomial that meets position, velocity and
    acceleration at both; before the first point and after the last one it stands still.

    Attributes:
        joints: N names; the columns follow them.
        time: (K,) s from the start, increasing.
        q: (K, N) rad.  qd: (K, N) rad/s.  qdd: (K, N) rad/s².
        filled: what was not given and had to be filled in, in words.
    """

    joints: tuple[str, ...]
    time: Floats
    q: Floats
    qd: Floats
    qdd: Floats
    filled: tuple[str, ...] = ()

    @property
    def duration(self) -> float:
        """Time of the last point, s."""
        return float(self.time[-1])

    @property
    def is_setpoint(self) -> bool:
        """One point at time 0: a sample of a stream of set-points."""
        return len(self.time) == 1

    def sample(self, time: Floats) -> tuple[Floats, Floats, Floats]:
        """q, qd, qdd, each (..., N), at times (...) from the start."""
        if self.is_setpoint:
            rows = np.zeros(np.shape(time), dtype=np.int64)
            return self.q[rows], self.qd[rows], self.qdd[rows]
        t = self.time
        inside = np.minimum(np.maximum(time, t[0]), t[-1])
        left = np.minimum(np.searchsorted(t, inside, side="right") - 1, len(t) - 2)
        powers = FACTOR * (inside - t[left])[..., None, None] ** EXPONENT
        powers[..., 1:, :] *= (inside == time)[..., None, None]
        state = powers @ self._coefficients[left]
        return state[..., 0, :], state[..., 1, :], state[..., 2, :]

    @cached_property
    def _coefficients(self) -> Floats:
        """(K - 1, 6, N) of the powers of the time since the left point."""
        h = np.diff(self.time)[:, None]
        p, v, a = self.q[:-1], self.qd[:-1] * h, self.qdd[:-1] * h**2
        d, w, b = self.q[1:] - p, self.qd[1:] * h, self.qdd[1:] * h**2
        return np.stack(
            [
                p,
                v / h,
                0.5 * a / h**2,
                (10 * d - 6 * v - 4 * w - 1.5 * a + 0.5 * b) / h**3,
                (-15 * d + 8 * v + 7 * w + 1.5 * a - b) / h**4,
                (6 * d - 3 * (v + w) - 0.5 * (a - b)) / h**5,
            ],
            axis=1,
        )


LONGEST = 3600.0
"""s that a reference may last: times in other units than seconds would fill the memory."""


def read_reference(points: Points, joints: Sequence[str], max_points: int = 100_000) -> Reference:
    """Check a trajectory and complete it.

    Columns are matched by name: any order, further joints are ignored. Missing velocities and
    accelerations come from a 5th-order spline through the positions that starts and ends at
    rest; accelerations missing beside given velocities from a cubic spline of the velocities.
    A set-point (one point at time 0) has no neighbours: what it lacks is zero.

    Args:
        points: the message.
        joints: the N joints wanted, in this order.
        max_points: refuse longer ones.

    Raises:
        RefusedReference: names the joint and the point that are wrong.
    """
    columns = _columns(points.names, joints)
    count = len(points.time)
    if not 1 <= count <= max_points:
        raise RefusedReference(f"{count} points; expected 1 to {max_points}")
    time = np.asarray(points.time, dtype=np.float64)
    if count > 1 or points.time[0] != 0.0:
        _check_time(time)
    if time[-1] > LONGEST:
        raise RefusedReference(
            f"it lasts {time[-1]:.0f} s, expected at most {LONGEST:.0f} s; is time_from_start in "
            "seconds?"
        )
    q = _table(points.position, "position", points.names, columns)
    if q is None:
        raise RefusedReference("the points have no positions")
    qd = _table(points.velocity, "velocity", points.names, columns)
    qdd = _table(points.acceleration, "acceleration", points.names, columns)
    filled = []
    if count == 1:
        if qd is None:
            filled.append("velocities by zeros")
        if qdd is None:
            filled.append("accelerations by zeros")
        zeros = np.zeros_like(q)
        qd = zeros if qd is None else qd
        qdd = zeros if qdd is None else qdd
    elif qd is None:
        rest = [(1, np.zeros(q.shape[1])), (2, np.zeros(q.shape[1]))]
        spline = scipy.interpolate.make_interp_spline(time, q, k=5, bc_type=(rest, rest))
        qd = spline(time, 1)
        filled.append("velocities by a spline through the positions")
        if qdd is None:
            qdd = spline(time, 2)
            filled.append("accelerations by a spline through the positions")
    elif qdd is None:
        qdd = scipy.interpolate.CubicSpline(time, qd)(time, 1)
        filled.append("accelerations by a spline through the velocities")
    return Reference(tuple(joints), time, q, qd, qdd, tuple(filled))


def read_effort(points: Points, joints: Sequence[str]) -> Floats | None:
    """(K, N) N·m the trajectory carries for these joints, or None where it carries none.

    Raises:
        RefusedReference: names the joint and the point that are wrong.
    """
    return _table(points.effort, "effort", points.names, _columns(points.names, joints))


def _columns(names: Sequence[str], joints: Sequence[str]) -> list[int]:
    if len(set(names)) != len(names):
        raise RefusedReference(f"it names a joint twice: {', '.join(names)}")
    if list(names) == list(joints):
        return list(range(len(joints)))
    missing = [joint for joint in joints if joint not in names]
    if missing:
        raise RefusedReference(
            f"no joint {', '.join(missing)}; it moves {', '.join(names) or 'no joints'}"
        )
    return [list(names).index(joint) for joint in joints]


def _check_time(time: Floats) -> None:
    if not np.isfinite(time).all() or time[0] < 0.0:
        raise RefusedReference("time_from_start must be finite and not negative")
    backwards = np.flatnonzero(np.diff(time) <= 0.0)
    if len(backwards):
        at = int(backwards[0]) + 1
        raise RefusedReference(
            f"time_from_start must increase; point {at} is at {time[at]:.6g} s after one at "
            f"{time[at - 1]:.6g} s"
        )
    if len(time) == 1 and time[0] > 0.0:
        raise RefusedReference(
            f"one point at {time[0]:.6g} s has no start: give at least two points, or one at "
            "time 0 for a streamed set-point"
        )


def _table(
    rows: Sequence[Sequence[float]], label: str, names: Sequence[str], columns: list[int]
) -> Floats | None:
    """(K, N) of the wanted columns, or None where every row is empty."""
    lengths = {len(row) for row in rows}
    if lengths <= {0}:
        return None
    if lengths != {len(names)}:
        wrong = next(k for k, row in enumerate(rows) if len(row) != len(names))
        raise RefusedReference(
            f"point {wrong} has {len(rows[wrong])} {label} values for {len(names)} joints"
        )
    if len(rows) == 1:  # a set-point: ten times as fast, of many rows three times as slow
        flat = np.array(rows[0], dtype=np.float64)
    else:
        flat = np.fromiter(chain.from_iterable(rows), np.float64, len(rows) * len(names))
    table = flat.reshape(len(rows), len(names))[:, columns]
    if not np.isfinite(table).all():
        point, joint = np.argwhere(~np.isfinite(table))[0]
        raise RefusedReference(
            f"the {label} of {names[columns[joint]]} in point {point} is {table[point, joint]}"
        )
    return table
