"""The motion to follow: read from a message, completed, and followed without jumps."""

import threading
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import chain
from typing import Literal

import numpy as np
import scipy

from lagrangian_ff import budget
from lagrangian_ff.arrays import Floats
from lagrangian_ff.errors import UserError


class RefusedReference(UserError):  # noqa: N818
    """A reference motion that cannot be followed."""


# d^r/dt^r of t^k is FACTOR[r, k] t^EXPONENT[r, k].
EXPONENT = np.array([[0, 1, 2, 3, 4, 5], [0, 0, 1, 2, 3, 4], [0, 0, 0, 1, 2, 3]])
FACTOR = np.array([[1.0, 1, 1, 1, 1, 1], [0, 1, 2, 3, 4, 5], [0, 0, 2, 6, 12, 20]])


@dataclass(frozen=True)
class Points:
    """The content of a trajectory message: rows may be empty or of the wrong length.

    Attributes:
        names: joints in the order of the columns.
        time: K times from the start, s.
        position: K rows; velocity, acceleration, effort: K rows, empty if not given.
    """

    names: Sequence[str]
    time: Sequence[float]
    position: Sequence[Sequence[float]]
    velocity: Sequence[Sequence[float]]
    acceleration: Sequence[Sequence[float]]
    effort: Sequence[Sequence[float]] = ()


@dataclass(frozen=True)
class Reference:
    """The wanted motion of N joints at K times.

    Between two points the motion is the polynomial that meets at both what its degree has room for:
    5, position, velocity and acceleration; 3, position and velocity; 1, the position. Where the
    polynomials of two intervals differ in velocity or acceleration, at a point, its state is the
    mean of both. Before the first point and after the last one the motion stands still.

    Attributes:
        joints: N names; the columns follow them.
        time: (K,) s from the start, increasing.
        q: (K, N) rad.  qd: (K, N) rad/s.  qdd: (K, N) rad/s².
        filled: what the message lacked and how it was filled in, in words.
        degree: of the polynomials, 5, 3 or 1.
    """

    joints: tuple[str, ...]
    time: Floats
    q: Floats
    qd: Floats
    qdd: Floats
    filled: tuple[str, ...] = ()
    degree: int = 5

    @property
    def duration(self) -> float:
        """Return the time of the last point, s."""
        return float(self.time[-1])

    @property
    def is_setpoint(self) -> bool:
        """Return whether it is one point at time 0, a sample of a stream of set-points."""
        return len(self.time) == 1

    def sample(self, time: Floats) -> tuple[Floats, Floats, Floats]:
        """Return q, qd, qdd, each (..., N), at times (...) in s from the start."""
        if self.is_setpoint:
            rows = np.zeros(np.shape(time), dtype=np.int64)
            return self.q[rows], self.qd[rows], self.qdd[rows]
        state = self._state(time, "right")
        if self.degree < 5:
            state = 0.5 * (state + self._state(time, "left"))
        return state[..., 0, :], state[..., 1, :], state[..., 2, :]

    def _state(self, time: Floats, side: Literal["left", "right"]) -> Floats:
        """Return (..., 3, N), at a point that of the interval on this side of it."""
        t = self.time
        inside = np.minimum(np.maximum(time, t[0]), t[-1])
        left = np.clip(np.searchsorted(t, inside, side=side) - 1, 0, len(t) - 2)
        powers = FACTOR * (inside - t[left])[..., None, None] ** EXPONENT
        powers[..., 1:, :] *= (inside == time)[..., None, None]
        return np.asarray(powers @ self._coefficients[left])

    @cached_property
    def _coefficients(self) -> Floats:
        """Return the coefficients (K - 1, 6, N) of the powers of the time since the left point."""
        h = np.diff(self.time)[:, None]
        p, v, a = self.q[:-1], self.qd[:-1] * h, self.qdd[:-1] * h**2
        d, w, b = self.q[1:] - p, self.qd[1:] * h, self.qdd[1:] * h**2
        none = np.zeros_like(p)
        if self.degree == 1:
            return np.stack([p, d / h, none, none, none, none], axis=1)
        if self.degree == 3:
            cubic = [(3 * d - 2 * v - w) / h**2, (v + w - 2 * d) / h**3]
            return np.stack([p, v / h, *cubic, none, none], axis=1)
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
    """Check a trajectory, complete it and return it.

    Columns are matched by name: any order, further joints are ignored. Missing velocities and
    accelerations come from a 5th-order spline through the positions that starts and ends at
    rest; accelerations missing beside given velocities from a cubic spline of the velocities.
    A set-point (one point at time 0) has no neighbours: zeros fill what it lacks.

    Args:
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


def read_path(points: Points, joints: Sequence[str], max_points: int = 100_000) -> Reference:
    """Return a trajectory as joint_trajectory_controller interpolates it.

    Its polynomials are of degree 5 between points with velocities and accelerations, 3 between
    points with velocities, 1 between positions alone (trajectory.cpp of ros2_controllers, Jazzy).

    Args:
        joints, max_points: as of `read_reference`.

    Raises:
        RefusedReference: names the joint and the point that are wrong.
    """
    reference = read_reference(points, joints, max_points)
    if reference.is_setpoint:
        raise RefusedReference("one point is no path: give two or more")
    with_velocity, with_acceleration = (
        any(map(len, points.velocity)),
        any(map(len, points.acceleration)),
    )
    if with_acceleration and not with_velocity:
        raise RefusedReference("the points have accelerations and no velocities")
    degree = 5 if with_acceleration else 3 if with_velocity else 1
    return replace(reference, filled=(), degree=degree)


def read_effort(points: Points, joints: Sequence[str]) -> Floats | None:
    """Return the torque (K, N) N·m in the message for these joints, or None if it has none.

    Raises:
        RefusedReference: names the joint and the point that are wrong.
    """
    return _table(points.effort, "effort", points.names, _columns(points.names, joints))


def _columns(names: Sequence[str], joints: Sequence[str]) -> list[int]:
    if len(set(names)) != len(names):
        raise RefusedReference(f"it names a joint twice: {', '.join(names)[:200]}")
    if list(names) == list(joints):
        return list(range(len(joints)))
    missing = [joint for joint in joints if joint not in names]
    if missing:
        raise RefusedReference(
            f"no joint {', '.join(missing)}; it moves {', '.join(names)[:200] or 'no joints'}"
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
    """Return the wanted columns (K, N), or None if every row is empty."""
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
    if not np.abs(table).max(initial=0.0) <= budget.LARGEST:  # nan is not, either
        point, joint = np.argwhere(~(np.abs(table) <= budget.LARGEST))[0]
        raise RefusedReference(
            f"the {label} of {names[columns[joint]]} in point {point} is {table[point, joint]}"
        )
    return table


@dataclass(frozen=True)
class Segment:
    """A reference with its start.

    Attributes:
        start: ns.
        effort: (K, N) N·m at its points, linear between them; None if the message has none.
    """

    reference: Reference
    start: int
    effort: Floats | None = None

    def at(self, now: int) -> tuple[Floats, Floats, Floats]:
        """Return q, qd, qdd, each (N,), at this time in ns."""
        return self.reference.sample(np.asarray((now - self.start) / 1e9))

    def effort_at(self, now: int) -> Floats:
        """Return the torque (N,) N·m at this time in ns: constant outside, zero without effort."""
        if self.effort is None:
            return np.zeros(len(self.reference.joints))
        time = self.reference.time
        elapsed = np.clip((now - self.start) / 1e9, time[0], time[-1])
        right = min(int(np.searchsorted(time, elapsed, side="right")), len(time) - 1)
        left = max(right - 1, 0)
        span = time[right] - time[left]
        share = (elapsed - time[left]) / span if span > 0.0 else 0.0
        return np.asarray(self.effort[left] * (1.0 - share) + self.effort[right] * share)


class Follower:
    """Follows one reference after another and stands still between them; it never jumps.

    One thread may accept references while another asks for the present state.

    Args:
        q: (N,) rad, the first position.
        tolerance: rad by which a new reference may differ from the present one when it
            takes over.
    """

    def __init__(self, joints: tuple[str, ...], q: Floats, tolerance: float) -> None:
        still = np.zeros((1, len(joints)))
        self._now = Segment(Reference(joints, np.zeros(1), q[None, :], still, still), 0)
        self._next: Segment | None = None
        self.tolerance = tolerance
        self._lock = threading.Lock()

    def accept(self, segment: Segment, now: int) -> None:
        """Follow this segment from its start on, instead of any other.

        Raises:
            RefusedReference: the position would jump there, or it is over already.
        """
        reference = segment.reference
        end = segment.start + round(reference.duration * 1e9)
        if not reference.is_setpoint and end < now:
            raise RefusedReference(
                f"it ended {(now - end) / 1e9:.3f} s ago; give a start in header.stamp that is "
                "still to come, or 0 for now"
            )
        takes_over = max(segment.start, now)
        jump = segment.at(takes_over)[0] - self._now.at(takes_over)[0]
        worst = int(np.argmax(np.abs(jump)))
        if abs(jump[worst]) > self.tolerance:
            late = (now - segment.start) / 1e9
            came = f"it came {late:.3f} s after its start: send it earlier"
            raise RefusedReference(
                f"{reference.joints[worst]} would jump by {jump[worst]:.4f} rad from the present "
                f"reference, more than the tolerance of {self.tolerance:g} rad; "
                f"{came if late > 0.0 else 'start where the arm is'}"
            )
        with self._lock:
            self._next = segment

    def at(self, now: int) -> tuple[Floats, Floats, Floats, Floats]:
        """Return q, qd, qdd and effort of the reference, each (N,), at this time in ns."""
        with self._lock:
            if self._next is not None and now >= self._next.start:
                self._now, self._next = self._next, None
        return (*self._now.at(now), self._now.effort_at(now))

    @property
    def has_effort(self) -> bool:
        """Return whether the present reference carries effort."""
        return self._now.effort is not None

    def moving(self, now: int) -> bool:
        """Return whether a motion goes on or is still to come."""
        segment = self._next or self._now
        return now < segment.start + segment.reference.duration * 1e9
