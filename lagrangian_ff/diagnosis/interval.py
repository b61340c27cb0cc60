"""Which torques a model thought possible, and how many of the measured ones are among them."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lagrangian_ff.identification import Model
from lagrangian_ff.identification.certainty.intervals import LEVEL
from lagrangian_ff.identification.certainty.uncertainty import quick_factor
from lagrangian_ff.progress import Progress, silent
from lagrangian_ff.recording.motion import Motion

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

MOST = 1500
"""Samples that are looked at where not all of them are asked for: what a page draws."""
TOO_FEW = 0.65
"""Share of torques inside 90 % intervals below which something is wrong, on a long motion: eight
models of simulated arms that had not changed since had at least 0.71 on every joint."""
CHANCE = 3.0
"""Standard deviations, one second counted as one, by which a short motion may fall below 90 %."""


@dataclass(frozen=True)
class Interval:
    """The 90 % intervals of predicted torques, and what was measured.

    Attributes:
        joints: N names.
        at: (S,) which samples of the motion were looked at.
        reach: (S, N) N·m to both sides of the prediction.
        covered: (N,) the share of their measured torques inside.
        seconds: how many independent samples they stand for, one a second.
    """

    joints: tuple[str, ...]
    at: Ints
    reach: Floats
    covered: Floats
    seconds: int

    @property
    def too_sure(self) -> tuple[str, ...]:
        """The joints with far fewer torques inside than there should be, the worst first."""
        chance = CHANCE * np.sqrt(LEVEL * (1.0 - LEVEL) / self.seconds)
        limit = min(TOO_FEW, LEVEL - chance)
        order = np.argsort(self.covered)
        return tuple(self.joints[n] for n in order if self.covered[n] < limit)

    def words(self) -> str:
        """What to tell a person where the model is too sure; else empty."""
        share = dict(zip(self.joints, self.covered, strict=True))
        few = ", ".join(f"{share[name]:.0%} of {name}" for name in self.too_sure)
        if not few:
            return ""
        return (
            f"The model is surer than it should be: of the measured torques only {few} lie inside "
            f"its {LEVEL:.0%} intervals. Something changed since it was identified, or is missing"
        )

    def record(self) -> dict[str, object]:
        """For JSON."""
        return {
            "covered": dict(zip(self.joints, map(float, self.covered), strict=True)),
            "too_sure": self.words(),
        }


def every(motion: Motion, most: int = MOST) -> Ints:
    """Positions of at most so many samples of a motion, every second, third ... of them."""
    return np.arange(0, len(motion), max(1, -(-len(motion) // most)))


def interval(
    model: Model,
    motion: Motion,
    predicted: Floats,
    at: Ints | None = None,
    progress: Progress = silent,
) -> Interval:
    """The intervals along a motion, from the cheap form of the model's certainty.

    Args:
        model: the model.
        motion: measured, of its joints in its order.
        predicted: (M, N) N·m.
        at: (S,) the samples to look at; all without it.
        progress: told the share done.

    Raises:
        ModelError: the model is of before its calibration was kept, and cannot be calibrated now.
    """
    at = np.arange(len(motion)) if at is None else at
    states = motion.q, motion.qd, motion.qdd
    certain = model.quick_uncertainty
    reach = certain.reach(*states, LEVEL, progress, time=motion.time, segment=motion.segment, at=at)
    inside = np.abs(motion.tau[at] - predicted[at]) <= reach
    seconds = int(motion.blocks(1.0)[-1]) + 1
    return Interval(model.joints, at, reach, inside.mean(axis=0), seconds)


def quick_interval(model: Model, motion: Motion, predicted: Floats) -> Interval | None:
    """The same at few samples; None where the model's file is of before this took an instant."""
    if quick_factor(model) is None or not len(motion):
        return None
    return interval(model, motion, predicted, every(motion))
