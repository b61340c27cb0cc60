"""The rules of joint_trajectory_controller on Jazzy, as far as the tests need them.

After trajectory.cpp and joint_trajectory_controller.cpp of ros2_controllers, written down anew and
apart from the package, so that the package is compared with them.
"""

from bisect import bisect_right
from typing import Any

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


def seconds(duration: Any) -> float:
    return float(duration.sec) + float(duration.nanosec) * 1e-9


def complaint(trajectory: Any, joints: list[str], takes_effort: bool) -> str:
    """Return why a goal is rejected, or ""."""
    if sorted(trajectory.joint_names) != sorted(joints):
        return f"Joints {list(trajectory.joint_names)} are not those of the controller"
    if not trajectory.points:
        return "Empty trajectory received"
    before = -1.0
    for number, point in enumerate(trajectory.points):
        at = seconds(point.time_from_start)
        if at <= before:
            return f"Time between points {number - 1} and {number} is not strictly increasing"
        before = at
        if len(point.positions) != len(joints):
            return f"Point {number} has {len(point.positions)} positions"
        for kind in ("velocities", "accelerations", "effort"):
            if len(getattr(point, kind)) not in (0, len(joints)):
                return f"Point {number} has {len(getattr(point, kind))} {kind}"
        if len(point.effort) and not takes_effort:
            return f"Point {number} has effort, and no effort command interface is claimed"
    if any(abs(v) > np.finfo(np.float32).eps for v in trajectory.points[-1].velocities):
        return "Velocity of last trajectory point is not zero"
    return ""


class Motion:
    """A trajectory as the controller samples it.

    Args:
        q: (N,) rad at which the arm stands, from which the first point is reached.
    """

    def __init__(self, trajectory: Any, joints: list[str], q: Floats) -> None:
        order = [list(trajectory.joint_names).index(joint) for joint in joints]
        self._points = list(trajectory.points)
        self._time = [seconds(point.time_from_start) for point in self._points]
        self._order, self._start = order, q
        self.duration = self._time[-1]

    def _values(self, point: Any, kind: str) -> Floats | None:
        values = getattr(point, kind)
        return np.array(values)[self._order] if len(values) else None

    def at(self, time: float) -> tuple[Floats, Floats, Floats]:
        """Return position, velocity and effort, each (N,), `time` s after the start."""
        none = np.zeros(len(self._order))
        right = bisect_right(self._time, time)
        if right == len(self._time):
            q = self._values(self._points[-1], "positions")
            effort = self._values(self._points[-1], "effort")
            assert q is not None
            return q, none, none if effort is None else effort
        if right == 0:
            q = self._values(self._points[0], "positions")
            assert q is not None
            share = time / self._time[0]
            return self._start + (q - self._start) * share, (q - self._start) / self._time[0], none
        a, b = self._points[right - 1], self._points[right]
        span, t = self._time[right] - self._time[right - 1], time - self._time[right - 1]
        q, qd = self._between(a, b, span, t)
        fa, fb = self._values(a, "effort"), self._values(b, "effort")
        effort = none if fa is None or fb is None else fa + (fb - fa) * t / span
        return q, qd, effort

    def _between(self, a: Any, b: Any, span: float, t: float) -> tuple[Floats, Floats]:
        p, q = self._values(a, "positions"), self._values(b, "positions")
        v, w = self._values(a, "velocities"), self._values(b, "velocities")
        s, u = self._values(a, "accelerations"), self._values(b, "accelerations")
        assert p is not None
        assert q is not None
        rows, values = [[1, 0, 0, 0, 0, 0], [span**k for k in range(6)]], [p, q]
        if v is not None and w is not None:
            rows += [[0, 1, 0, 0, 0, 0], [0, *(k * span ** (k - 1) for k in range(1, 6))]]
            values += [v, w]
            if s is not None and u is not None:
                second = [0, 0, *(k * (k - 1) * span ** (k - 2) for k in range(2, 6))]
                rows += [[0, 0, 2, 0, 0, 0], second]
                values += [s, u]
        order = len(rows)
        polynomial = np.linalg.solve(np.array(rows, dtype=float)[:, :order], np.array(values))
        powers = t ** np.arange(order)
        slopes = np.arange(order) * t ** np.maximum(np.arange(order) - 1, 0)
        return np.asarray(powers @ polynomial), np.asarray(slopes @ polynomial)
