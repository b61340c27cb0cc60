"""Limits of designed motions: how far a motion goes towards each, and how to stay inside."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from lagrangian_ff.arrays import Floats
from lagrangian_ff.diagnosis.excite.path import GRID, Limits, Reference
from lagrangian_ff.diagnosis.excite.splines import Splines
from lagrangian_ff.identification import Model
from lagrangian_ff.recording.motion import Motion

INSIDE = 0.98
"""Share of a limit that the search aims at: what it then exceeds, slowing down mends."""
ROUNDING = 1e-9
SLOWER = 1.01
"""Factor of time by which a motion is slowed down again and again until its torque is allowed."""
MOST_SLOWINGS = 12
SMALLER = 0.8
EVERY = 4
"""Points of a motion, every fourth of which has its torque predicted during the search."""
STEP = 1e-6

Clear = Callable[[Floats], str]
"""(M, N) rad, a path -> what touches on it, in words; empty if nothing does."""


def jerk_of(q: Reference) -> Floats:
    """Return (K - 1, N) rad/s³ between the points of a motion."""
    return np.asarray(np.diff(q.qdd, axis=0) / np.diff(q.time)[:, None])


def seen_jerk(data: Motion) -> Floats:
    """Return (N,) rad/s³, the largest jerk of a recorded motion."""
    inside = np.diff(data.segment) == 0
    return np.asarray(
        np.abs(np.diff(data.qdd, axis=0)[inside] / np.diff(data.time)[inside, None]).max(axis=0)
    )


def limits_of(model: Model) -> Limits:
    """Return what a model's own data reached, a margin inside."""
    seen = model.range
    jerk = seen_jerk(model.data)
    every = Limits(seen.q_low, seen.q_high, seen.qd_max, seen.qdd_max, jerk, seen.tau_max)
    return Limits.within(every, model.joints)


@dataclass(frozen=True)
class Keeper:
    """Limits of an arm, its torque as a model predicts it, and what is in its way.

    Attributes:
        margin: (N,) N·m, kept besides from the limits of torque: how wrong the model may be.
    """

    model: Model
    limits: Limits
    margin: Floats
    clear: Clear | None = None

    @property
    def tau_max(self) -> Floats:
        """Return (N,) N·m that may be predicted; infinite without a limit."""
        most = self.limits.tau_max
        if most is None:
            return np.full(len(self.model.joints), np.inf)
        return np.maximum(most - self.margin, 0.0)

    def used(self, made: Reference) -> Mapping[str, Floats]:
        """Return (N,) the share of each limit that a motion takes, 0 to 1 if it keeps it."""
        limits = self.limits
        tau = self.model.predict(made.q, made.qd, made.qdd, time=made.time)
        half = np.maximum(0.5 * limits.width, 1e-9)
        peaks = {
            "position": np.abs(made.q - limits.middle).max(axis=0) / half,
            "speed": _share(made.qd, limits.qd_max),
            "acceleration": _share(made.qdd, limits.qdd_max),
            "torque": _share(tau, self.tau_max),
        }
        if limits.jerk_max is not None:
            peaks["jerk"] = _share(jerk_of(made), limits.jerk_max)
        return peaks

    def kept(self, splines: Splines, control: Floats) -> Splines | None:
        """Return the splines slowed down until all limits hold; None if no tempo allows it."""
        for _ in range(MOST_SLOWINGS):
            made = splines.reference(control)
            used = self.used(made)
            if all(float(one.max()) <= 1.0 + ROUNDING for one in used.values()):
                return splines
            if float(used["position"].max()) > 1.0 + ROUNDING:
                return None
            splines = splines.slower(max(SLOWER, self._slower(made)))
        return None

    def _slower(self, made: Reference) -> float:
        """Return the factor of time by which speed, acceleration and jerk keep their limits."""
        limits = self.limits
        factors = [
            _share(made.qd, limits.qd_max).max(),
            _share(made.qdd, limits.qdd_max).max() ** 0.5,
        ]
        if limits.jerk_max is not None:
            factors.append(_share(jerk_of(made), limits.jerk_max).max() ** (1.0 / 3.0))
        return max(1.0, *map(float, factors))

    def cleared(self, splines: Splines, control: Floats, back: Floats) -> Floats | None:
        """Return control points, moved back towards those of a clear motion until they are clear.

        None if even a fifth of the way is not.
        """
        if self.clear is None:
            return control
        share = 1.0
        while share > 0.2:
            moved = back + share * (control - back)
            if not self.clear(splines.rates[0][::EVERY] @ moved):
                return moved
            share *= SMALLER
        return None

    def penalty(self, splines: Splines, control: Floats) -> tuple[float, Floats]:
        """Return the squared excess over the limits, integrated over time, and its slope."""
        limits = self.limits
        bounds = [limits.qd_max, limits.qdd_max, limits.jerk_max]
        value, slope = 0.0, np.zeros_like(control)
        for rate, most in zip(splines.rates[1:], bounds, strict=True):
            if most is not None:
                some = rate[::2]
                over, by = _excess(some @ control, most, 2 * GRID)
                value += over
                slope += some.T @ by
        over, by_torque = self._torque_penalty(splines, control)
        return value + over, slope + by_torque

    def _torque_penalty(self, splines: Splines, control: Floats) -> tuple[float, Floats]:
        rows = [rate[::EVERY] for rate in splines.rates[:3]]
        x = [one @ control for one in rows]
        time = splines.time[::EVERY]
        q, qd, qdd = x
        tau = self.model.predict(q, qd, qdd, time=time)
        value, by_torque = _excess(tau, self.tau_max, EVERY * GRID)
        slope = np.zeros_like(control)
        bad = np.flatnonzero(by_torque.any(axis=1))
        if not len(bad):
            return value, slope
        few = [one[bad] for one in x]
        before = self._torque(*few)
        for order in range(3):
            moved = np.zeros_like(few[0])
            for n in range(control.shape[1]):
                other = [one.copy() for one in few]
                other[order][:, n] += STEP
                change = (self._torque(*other) - before) / STEP
                moved[:, n] = np.sum(change * by_torque[bad], axis=1)
            slope += rows[order][bad].T @ moved
        return value, slope

    def _torque(self, q: Floats, qd: Floats, qdd: Floats) -> Floats:
        return self.model.predict(q, qd, qdd)


def _share(values: Floats, most: Floats) -> Floats:
    return np.asarray(np.abs(values).max(axis=0) / np.maximum(most, 1e-9))


def _excess(values: Floats, most: Floats, step: float) -> tuple[float, Floats]:
    """Return the integral of the squared excess over a limit, and its slope by the values (M, N).

    Args:
        step: s between the values.
    """
    limit = np.maximum(INSIDE * most, 1e-9)
    over = np.maximum(np.abs(values) / limit - 1.0, 0.0)
    return step * float(np.sum(over**2)), step * 2.0 * over * np.sign(values) / limit
