"""A motion within limits, put together from moves, runs and waves: smooth, from rest to rest."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields, replace
from typing import NamedTuple

import numpy as np
import scipy

from lagrangian_ff.arrays import Floats
from lagrangian_ff.errors import ModelError
from lagrangian_ff.identification.predicting import MotionRange

MARGIN = 0.05
"""Kept from the ends of a range, in parts of it."""
GRID = 0.01
"""s between the points."""
REST = 0.2
"""s at rest between two parts."""
_SHORTEST_MOVE = 0.1  # s
_GENTLE = 0.5  # of speed and acceleration allowed, where nothing is to be shown by them
_STRETCHES = 20  # attempts to slow a wave down until it keeps the limits


@dataclass(frozen=True)
class Limits:
    """The range, speed, acceleration, jerk and torque that a motion must not leave.

    Attributes:
        q_low, q_high: (N,) rad.  qd_max: (N,) rad/s.  qdd_max: (N,) rad/s².
        jerk_max: (N,) rad/s³.  tau_max: (N,) N·m. None of these two is no limit; only designed
            motions keep them.
    """

    q_low: Floats
    q_high: Floats
    qd_max: Floats
    qdd_max: Floats
    jerk_max: Floats | None = None
    tau_max: Floats | None = None

    @classmethod
    def within(
        cls, known: "MotionRange | Limits", joints: Sequence[str], margin: float = MARGIN
    ) -> "Limits":
        """Return limits a margin inside the range of a model or the limits of an arm.

        Raises:
            ModelError: values that are not finite or leave no room at all; names the joint.
        """
        found = {
            one.name: np.array(value, dtype=np.float64)
            for one in fields(cls)
            if (value := getattr(known, one.name, None)) is not None
        }
        low, high = found.pop("q_low"), found.pop("q_high")
        for n, name in enumerate(joints):
            if not np.isfinite([low[n], high[n], *(one[n] for one in found.values())]).all():
                raise ModelError(f"{name}: its limits are not finite numbers")
            if high[n] < low[n] or any(one[n] < 0.0 for one in found.values()):
                raise ModelError(
                    f"{name}: limits of {low[n]:g} to {high[n]:g} rad, {found['qd_max'][n]:g} "
                    f"rad/s and {found['qdd_max'][n]:g} rad/s² leave no room to move"
                )
        inside = margin * (high - low)
        largest = {name: (1.0 - margin) * most for name, most in found.items()}
        return cls(low + inside, high - inside, **largest)

    @property
    def middle(self) -> Floats:
        """Return (N,) rad."""
        return 0.5 * (self.q_low + self.q_high)

    @property
    def width(self) -> Floats:
        """Return (N,) rad."""
        return self.q_high - self.q_low

    def around(self, pose: Floats, reach: float) -> "Limits":
        """Return the limits with positions within a share of the way from a pose (N,) to them."""
        low, high = (pose + reach * (end - pose) for end in (self.q_low, self.q_high))
        return replace(self, q_low=low, q_high=high)

    def gentler(self, factor: float) -> "Limits":
        """Return the same positions, with speed by a factor and acceleration by its square."""
        return replace(self, qd_max=factor * self.qd_max, qdd_max=factor**2 * self.qdd_max)


class Reference(NamedTuple):
    """A motion to follow.

    Attributes:
        time: (K,) s, from 0, every `GRID`.
        q: (K, N) rad.  qd: (K, N) rad/s.  qdd: (K, N) rad/s².
    """

    time: Floats
    q: Floats
    qd: Floats
    qdd: Floats


class Path:
    """Parts of a motion, one after the other, each beginning and ending at rest.

    The acceleration is continuous everywhere, and every part lasts a whole number of `GRID`, so
    that the quintics between the points are the motion itself.

    Args:
        start: (N,) rad, where it begins.  limits: never left.

    Attributes:
        at: (N,) rad, where it ends so far.
    """

    def __init__(self, start: Floats, limits: Limits) -> None:
        self.limits = limits
        self.at = np.array(start, dtype=np.float64)
        still = np.zeros((1, len(self.at)))
        self._parts = [(self.at[None, :].copy(), still, still)]

    def rest(self, seconds: float = REST) -> None:
        """Stay at rest."""
        shape = (_steps(seconds), len(self.at))
        self._append(np.broadcast_to(self.at, shape), np.zeros(shape), np.zeros(shape))

    def move(self, goal: Floats, seconds: float = 0.0) -> None:
        """Go to (N,) rad along the polynomial of least jerk, gently, within `seconds` or more."""
        distance = np.abs(goal - self.at)
        if not np.any(distance > 0.0):
            return
        # Its speed peaks at 15/8 of the mean, its acceleration at 10/sqrt(3) distance / time².
        moving = distance > 0.0
        by_speed = 1.875 * distance[moving] / (_GENTLE * self.limits.qd_max[moving])
        by_hardness = np.sqrt(5.7736 * distance[moving] / (_GENTLE * self.limits.qdd_max[moving]))
        seconds = max(seconds, float(by_speed.max()), float(by_hardness.max()), _SHORTEST_MOVE)
        count = _steps(seconds)
        span, u = GRID * count, np.arange(1, count + 1)[:, None] / count
        way = (goal - self.at)[None, :]
        self._append(
            self.at + way * u**3 * (10.0 - 15.0 * u + 6.0 * u**2),
            way * 30.0 * u**2 * (1.0 - u) ** 2 / span,
            way * 60.0 * u * (1.0 - u) * (1.0 - 2.0 * u) / span**2,
        )

    def move_joint(self, joint: int, goal: float, seconds: float = 0.0) -> None:
        """Go to rad with one joint, as `move` does; the others stay."""
        end = self.at.copy()
        end[joint] = goal
        self.move(end, seconds)

    def run(self, joint: int, goal: float, speed: float) -> None:
        """Take one joint to rad at a constant speed in rad/s, with short smooth ramps.

        The speed is less where the way is too short for the ramps.
        """
        way = goal - float(self.at[joint])
        if way == 0.0:
            return
        hardness = float(self.limits.qdd_max[joint])
        # A ramp up takes 3/2 speed / acceleration; both together may take 0.6 of the way.
        top = min(speed, float(self.limits.qd_max[joint]), np.sqrt(0.4 * hardness * abs(way)))
        ramp = _steps(max(1.5 * top / hardness, _SHORTEST_MOVE / 2))
        cruise = max(0, int(np.ceil(abs(way) / (top * GRID) - ramp - 1e-9)))
        top = way / (GRID * (ramp + cruise))
        u = np.arange(1, ramp + 1) / ramp
        up = top * u**2 * (3.0 - 2.0 * u)
        hard = top * 6.0 * u * (1.0 - u) / (GRID * ramp)
        climbed = top * GRID * ramp * (u**3 - 0.5 * u**4)
        across = climbed[-1] + top * GRID * np.arange(1, cruise + 1)
        end = across[-1] if cruise else climbed[-1]
        down = top * GRID * ramp * (u - (u**3 - 0.5 * u**4))
        q, qd, qdd = np.zeros((3, 2 * ramp + cruise, len(self.at)))
        q += self.at
        q[:, joint] += np.concatenate([climbed, across, end + down])
        qd[:, joint] = np.concatenate([up, np.full(cruise, top), top - up])
        qdd[:, joint] = np.concatenate([hard, np.zeros(cruise), -hard])
        self._append(q, qd, qdd)

    def wave(self, shape: Callable[[Floats], Floats], seconds: float) -> None:
        """Follow positions that are a function of the share of the time, slower if need be.

        Args:
            shape: (K,) shares from 0 to 1 -> (K, N) rad within the limits; begins where the path
                is, at rest, and ends at rest.
            seconds: how long it should last; it lasts longer where the limits ask for that.
        """
        for _ in range(_STRETCHES):
            count = max(_steps(seconds), 8)
            time = GRID * np.arange(count + 1)
            q = shape(np.arange(count + 1) / count)
            still = np.zeros(q.shape[1])
            rest = [(1, still), (2, still)]
            spline = scipy.interpolate.make_interp_spline(time, q, k=5, bc_type=(rest, rest))
            qd, qdd = spline(time, 1), spline(time, 2)
            excess = self._excess(qd, qdd)
            if excess <= 1.0:
                break
            seconds *= 1.01 * excess
        self._append(q[1:], qd[1:], qdd[1:])

    def _excess(self, qd: Floats, qdd: Floats) -> float:
        """Return the factor by which the motion is too fast."""
        worst = 0.0
        for values, most, power in ((qd, self.limits.qd_max, 1.0), (qdd, self.limits.qdd_max, 0.5)):
            peak = np.abs(values).max(axis=0)
            moving = peak > 1e-12
            worst = max(worst, float(((peak[moving] / most[moving]) ** power).max(initial=0.0)))
        return worst

    def reference(self) -> Reference:
        """Return the whole motion."""
        q, qd, qdd = (np.concatenate(parts) for parts in zip(*self._parts, strict=True))
        time: Floats = GRID * np.arange(len(q), dtype=np.float64)
        return Reference(time, q, qd, qdd)

    def _append(self, q: Floats, qd: Floats, qdd: Floats) -> None:
        self._parts.append((q, qd, qdd))
        self.at = np.array(q[-1])


def _steps(seconds: float) -> int:
    return max(1, int(np.ceil(seconds / GRID - 1e-9)))
