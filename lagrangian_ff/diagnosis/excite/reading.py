"""The inputs that effects read of a motion under design."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.interpolate import CubicSpline

from lagrangian_ff.arrays import Floats, Ints
from lagrangian_ff.diagnosis.excite.splines import Splines
from lagrangian_ff.effects import Inputs
from lagrangian_ff.identification import Model
from lagrangian_ff.identification.basis import Term
from lagrangian_ff.kernels import States

SPARSE = 4
"""The slope of the load is computed at every fourth sample, and interpolated between them."""
STEP = 1e-6
"""Step of differences, relative to the largest value of a coordinate."""


@dataclass(frozen=True)
class Nearby:
    """The load of ways near to some, on which one joint goes elsewhere.

    Attributes:
        load: (R, N) N·m, of the ways.  slopes: (R, N) each, by q, qd and qdd of the joint.
    """

    load: Floats
    slopes: Sequence[Floats]

    def at(self, steps: Sequence[Floats]) -> Floats:
        """Return (R, N) N·m for small (R,) steps of q, qd and qdd."""
        parts = (step[:, None] * slope for step, slope in zip(steps, self.slopes, strict=True))
        return sum(parts, self.load)


@dataclass(frozen=True)
class Reading:
    """Reads what some effects need, and no more: the model's load of a whole motion costs most.

    Attributes:
        model: that predicts load and torque.
        terms: the effects.
        splines: the motions.  index: (S,) the samples of their time that are looked at.
        sign_speed: (N,) rad/s.
    """

    model: Model
    terms: Sequence[Term]
    splines: Splines
    index: Ints
    sign_speed: Floats

    def of(self, control: Floats) -> Inputs:
        """Return the samples of the motion of control points (K, N)."""
        x = self.of_ways([rate @ control for rate in self.rates], self.terms)
        has = self._remembers and of_whole(self.terms)
        return self.loaded(x) if self.uses and not has else x

    def of_ways(
        self, ways: Sequence[Floats], terms: Sequence[Term], load: Floats | None = None
    ) -> Inputs:
        """Return the samples of a motion, with a load only where effects need that of the past.

        Args:
            ways: q, qd and qdd at `rates`.  terms: the effects.
            load: (R, N) N·m that the model predicts for the ways, if it is known.
        """
        states, time = States.of(*ways), self.splines.time[self._rows]
        x = Inputs.of(states, time, np.zeros(len(states), dtype=np.int64))
        x = replace(x, sign_speed=self.sign_speed)
        if not self._remembers:
            return x
        return (self.loaded(x, load) if of_whole(terms) else x).take(self.index)

    def loaded(self, x: Inputs, load: Floats | None = None) -> Inputs:
        """Return inputs with the model's load, unless it is known, and its torque."""
        load = self._load(x.q, x.qd, x.qdd) if load is None else load
        width = self.model.basis.sign_speed(x.joints)
        read = replace(x, load=load, torque=load, sign_speed=width)
        return replace(x, load=load, torque=self.model.with_torque(read).torque)

    def nearby(
        self, ways: Sequence[Floats], load: Floats, joints: Iterable[int]
    ) -> "dict[int, Nearby]":
        """Return, for each of some joints, the load of ways on which it goes a little elsewhere.

        Args:
            ways: q, qd and qdd at `rates`.  load: (R, N) N·m that the model predicts for them.
        """
        count = len(load)
        rows = np.unique(np.append(np.arange(0, count, SPARSE), count - 1))
        some = [way[rows] for way in ways]
        found = {}
        for joint in joints:
            slopes = []
            for order, way in enumerate(some):
                step = STEP * max(float(np.abs(way).max()), 1e-3)
                moved = [one.copy() for one in some]
                moved[order][:, joint] += step
                slope = CubicSpline(rows, (self._load(*moved) - load[rows]) / step)
                slopes.append(slope(np.arange(count)))
            found[joint] = Nearby(load, slopes)
        return found

    def _load(self, q: Floats, qd: Floats, qdd: Floats) -> Floats:
        return self.model.inputs(q, qd, qdd).load

    @cached_property
    def rates(self) -> tuple[Floats, Floats, Floats]:
        """Return (R, K) each: q, qd and qdd by the control points, where effects need them."""
        q, qd, qdd, _ = self.splines.rates
        return q[self._rows], qd[self._rows], qdd[self._rows]

    @cached_property
    def uses(self) -> bool:
        """Return whether an effect uses the model's load or torque."""
        return any(term.effect.uses for term in self.terms)

    @cached_property
    def _remembers(self) -> bool:
        return any(term.effect.remembers for term in self.terms)

    @property
    def _rows(self) -> Ints | slice:
        return slice(None) if self._remembers else self.index


def of_whole(terms: Sequence[Term]) -> bool:
    """Return whether effects use the load of the past, or the torque, which has a past itself."""
    return any(
        "torque" in one.effect.uses or bool(one.effect.uses and one.effect.remembers)
        for one in terms
    )
