"""Whether a joint's torque is the model's times one factor, as another unit makes it.

A unit, a gear ratio or a torque constant scales all of a torque, whatever it comes from. A load
adds gravity and inertia, and leaves friction. So the measured torque is regressed on the parts of
the model's, and a unit is believed only where their factors agree and explain it.
"""

from dataclasses import dataclass

import numpy as np
import scipy

from lagrangian_ff.arrays import Floats
from lagrangian_ff.diagnosis.preflight.base import Case
from lagrangian_ff.identification.records import Estimate

BLOCKS = 12
"""Parts of the time that intervals are resampled over."""
LEVEL, SURE = 0.95, 0.995
"""The upper end of a 90 % interval, and of one beyond which factors surely differ."""
KNOWN = 0.2
"""Half width of an interval, relative to the factor, of a part that counts as known."""
TOLERATED = 0.1
"""Relative difference of factors that a model makes which shares a torque wrongly between parts."""
LEFT = 3.0
"""Multiple of the usual error, left with one factor, beyond which something else changed."""
FELT = 0.02
"""Share of the joint's torque that a part must have to be looked at."""


@dataclass(frozen=True)
class Scaled:
    """The factors of a joint's measured torque on the parts of the model's.

    Attributes:
        factors: by part, with 90 % intervals.
        apart: whether two of them surely differ: no unit does that.
        known: how many are known well enough to agree.
        left: the error that is left with one factor, over the model's usual error times it.
    """

    factors: dict[str, Estimate]
    apart: bool
    known: int
    left: float

    @property
    def objection(self) -> str:
        """Return why it is no unit, in words; empty if it may be one."""
        if self.apart:
            parts = ", ".join(
                f"{name} {one.value:.2f} [{one.low:.2f} to {one.high:.2f}]"
                for name, one in self.factors.items()
            )
            return f"no unit does that: its parts are {parts} of the model's"
        if self.left > LEFT:
            left = f"with this factor {self.left:.1f} times the usual error is left"
            return f"no unit does that: {left}"
        return ""


def scaled(case: Case, joint: int) -> Scaled:
    """Return the factors of a joint, from the samples inside the model's range."""
    thin, known = case.thin, case.known
    parts = case.parts
    moving = {
        "gravity": parts["gravity"][known, joint],
        "inertia": (parts["inertia"] + parts["coriolis"])[known, joint],
        "friction": parts["friction"][known, joint],
    }
    tau = thin.tau[known, joint]
    spread = float(np.std(tau))
    felt = [name for name, torque in moving.items() if np.std(torque) > FELT * spread]
    columns = np.column_stack([*(moving[name] for name in felt), np.ones(len(tau))])
    value, deviation, covariance = fitted(columns, tau)
    reach = scipy.special.stdtrit(BLOCKS - 1, LEVEL) * deviation
    factors = {
        name: Estimate(float(value[n]), float(value[n] - reach[n]), float(value[n] + reach[n]))
        for n, name in enumerate(felt)
    }
    sure = scipy.special.stdtrit(BLOCKS - 1, SURE)
    apart = False
    for a in range(len(felt)):
        for b in range(a):
            difference = abs(value[a] - value[b])
            variance = covariance[a, a] + covariance[b, b] - 2.0 * covariance[a, b]
            tolerated = TOLERATED * max(abs(value[a]), abs(value[b]))
            apart |= bool(difference > max(sure * np.sqrt(max(variance, 0.0)), tolerated))
    few = sum(r < KNOWN * abs(v) for v, r in zip(value[: len(felt)], reach, strict=False))
    factor, left = float(case.slope[joint]), tau - case.slope[joint] * case.predicted[known, joint]
    usual = factor * float(case.model.identified.validation.rmse[joint])
    return Scaled(factors, apart, int(few), float(np.std(left)) / usual if usual > 0.0 else 0.0)


def fitted(columns: Floats, tau: Floats) -> tuple[Floats, Floats, Floats]:
    """Return the coefficients (P,), their deviations and covariance, by the jackknife over time."""
    block = np.arange(len(tau)) * BLOCKS // len(tau)
    moments = np.array([columns[block == b].T @ columns[block == b] for b in range(BLOCKS)])
    sums = np.array([columns[block == b].T @ tau[block == b] for b in range(BLOCKS)])
    whole, total = moments.sum(axis=0), sums.sum(axis=0)
    value = np.linalg.lstsq(whole, total, rcond=None)[0]
    left = [
        np.linalg.lstsq(whole - moment, total - one, rcond=None)[0]
        for moment, one in zip(moments, sums, strict=True)
    ]
    away = np.array(left) - np.mean(left, axis=0)
    covariance = (BLOCKS - 1) / BLOCKS * away.T @ away
    return value, np.sqrt(np.diag(covariance)), covariance
