"""Motions as B-splines: from rest to rest, linear in their control points."""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import scipy

from lagrangian_ff.arrays import Floats
from lagrangian_ff.diagnosis.excite.path import GRID, Reference

DEGREE = 5
AT_REST = 3
"""Control points at each end that are the pose there: velocity and acceleration are then zero."""


@dataclass(frozen=True)
class Splines:
    """All motions of a duration with evenly spaced knots.

    Attributes:
        seconds: the duration, a whole number of `GRID`.  count: K control points a joint.
    """

    seconds: float
    count: int

    @cached_property
    def _knots(self) -> Floats:
        inner = np.linspace(0.0, self.seconds, self.count - DEGREE + 1)
        ends = np.ones(DEGREE)
        return np.concatenate([0.0 * ends, inner, self.seconds * ends])

    @cached_property
    def places(self) -> Floats:
        """Return (K,) s where each control point weighs most (Greville)."""
        knots = self._knots
        return np.array([knots[k + 1 : k + 1 + DEGREE].mean() for k in range(self.count)])

    @cached_property
    def time(self) -> Floats:
        """Return (M,) s, every `GRID`."""
        return GRID * np.arange(round(self.seconds / GRID) + 1, dtype=np.float64)

    @cached_property
    def rates(self) -> tuple[Floats, Floats, Floats, Floats]:
        """Return (M, K) each: q, qd, qdd and jerk at `time` by the control points."""
        unit = scipy.interpolate.BSpline(self._knots, np.eye(self.count), DEGREE)
        found = [np.asarray(unit(self.time, nu=order)) for order in range(4)]
        return found[0], found[1], found[2], found[3]

    def nearest(self, q: Floats, start: Floats) -> Floats:
        """Return the control points (K, N) of the motion nearest to positions (M, N).

        The positions are spread over the whole duration; the motion begins and ends at `start`,
        where joints that do not move stay.
        """
        moving = np.ptp(q, axis=0) > 0.0
        along = np.linspace(0.0, 1.0, len(q))
        at = self.time / self.seconds
        wanted = np.stack([np.interp(at, along, column) for column in q.T], axis=1)
        held = np.tile(start, (self.count, 1))
        inner = slice(AT_REST, self.count - AT_REST)
        whole = self.rates[0]
        found, *_ = np.linalg.lstsq(whole[:, inner], wanted - whole @ held, rcond=None)
        held[inner, moving] += found[:, moving]
        return held

    def slower(self, factor: float) -> "Splines":
        """Return the motions of the same ways that last `factor` times as long, or a little more.

        Their control points are the same.
        """
        return replace(self, seconds=GRID * int(np.ceil(factor * self.seconds / GRID - 1e-9)))

    def reference(self, control: Floats) -> Reference:
        """Return the motion of control points (K, N)."""
        q, qd, qdd, _ = (rate @ control for rate in self.rates)
        return Reference(self.time, q, qd, qdd)
