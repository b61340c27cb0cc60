"""The comparison of a model with a motion: predicted torque, errors, and 90 % intervals."""

from dataclasses import dataclass, replace

import numpy as np

from lagrangian_ff.arrays import Floats, Ints
from lagrangian_ff.diagnosis import thresholds
from lagrangian_ff.identification import Model, Score
from lagrangian_ff.identification.certainty.calibration import LEVEL
from lagrangian_ff.identification.certainty.uncertainty import quick_factor
from lagrangian_ff.kernels import States
from lagrangian_ff.progress import Progress, silent
from lagrangian_ff.recording.motion import Motion

OUTSIDE = 0.05
"""Excess over the identified range, in parts of it, from which a state counts as outside."""
MOST = 1500
"""Samples with an interval unless all are asked for: as many as a page draws."""


@dataclass(frozen=True)
class Interval:
    """The 90 % intervals of predicted torques, and the measured torques inside them.

    Attributes:
        joints: N names.  at: (S,) the samples of the motion.
        reach: (S, N) N·m to both sides of the prediction.
        covered: (N,) the share of measured torques inside.
        seconds: s of motion; each second counts as one independent sample.
    """

    joints: tuple[str, ...]
    at: Ints
    reach: Floats
    covered: Floats
    seconds: int

    @property
    def too_sure(self) -> tuple[str, ...]:
        """Return the joints with far fewer than 90 % of the torques inside, the worst first."""
        margin = thresholds.USED.covered_deviations * np.sqrt(LEVEL * (1.0 - LEVEL) / self.seconds)
        limit = min(thresholds.USED.covered_least, LEVEL - margin)
        order = np.argsort(self.covered)
        return tuple(self.joints[n] for n in order if self.covered[n] < limit)

    def words(self) -> str:
        """Return a sentence if the model is too sure; else an empty string."""
        share = dict(zip(self.joints, self.covered, strict=True))
        few = ", ".join(f"{share[name]:.0%} of {name}" for name in self.too_sure)
        if not few:
            return ""
        return (
            f"The model is surer than it should be: of the measured torques only {few} lie inside "
            f"its {LEVEL:.0%} intervals. Something changed since it was identified, or is missing"
        )

    def record(self) -> dict[str, object]:
        """Return the interval for JSON."""
        covered = dict(zip(self.joints, self.covered.tolist(), strict=True))
        return {"covered": covered, "too_sure": self.words()}


@dataclass(frozen=True)
class Comparison:
    """Predicted and measured torques.

    Attributes:
        motion: the measured motion, its joints in the model's order.
        predicted: (M, N) N·m.  score: the error per joint.
        outside: the share of samples outside the range that the model was identified on.
        interval: the 90 % intervals at some samples, if asked for.
        load: (M, N) N·m, the model's rigid-body torque; None if not kept.
    """

    motion: Motion
    predicted: Floats
    score: Score
    outside: float
    interval: Interval | None = None
    load: Floats | None = None

    @property
    def residual(self) -> Floats:
        """Return measured minus predicted torque, (M, N) N·m."""
        return self.motion.tau - self.predicted

    @property
    def warning(self) -> str:
        """Return a sentence if the model is too sure; empty if not, or without intervals."""
        return "" if self.interval is None else self.interval.words()

    @property
    def shown(self) -> Ints:
        """Return the samples that a page draws: those with an interval, else evenly spaced ones."""
        if self.interval is not None:
            return self.interval.at
        return np.arange(0, len(self.motion), max(1, -(-len(self.motion) // MOST)))

    def record(self) -> dict[str, object]:
        """Return the comparison for JSON."""
        return {
            **self.score.record(),
            "samples": len(self.motion),
            "outside_range": self.outside,
            "source": self.motion.source,
            **(self.interval.record() if self.interval else {}),
        }


def compare(
    model: Model, motion: Motion, progress: Progress = silent, *, intervals: bool = False
) -> Comparison:
    """Return the comparison of a model with a motion.

    Args:
        motion: measured; may hold more joints than the model, in any order.
        progress: receives the share done, 0 to 1.
        intervals: whether to add intervals at the samples that a page draws, if the model's file
            holds its quick uncertainty.

    Raises:
        ModelError: the motion lacks a joint of the model, or its effort holds another torque.
    """
    model.require_motion(motion)
    motion = motion.select(model.joints)
    states = motion.q, motion.qd, motion.qdd
    when, segment, temperature = motion.time, motion.segment, motion.temperature
    inputs = model.inputs(*states, progress, time=when, segment=segment, temperature=temperature)
    predicted = model.torque(inputs)
    score = Score.of(model.joints, motion.tau, predicted)
    excess = model.range.excess(States.of(*states))
    outside = float(np.mean(np.any(excess > OUTSIDE, axis=1)))
    found = Comparison(motion, predicted, score, outside, load=inputs.load)
    if not intervals or not len(motion) or quick_factor(model) is None:
        return found
    return with_intervals(model, found, at=found.shown)


def with_intervals(
    model: Model, comparison: Comparison, progress: Progress = silent, at: Ints | None = None
) -> Comparison:
    """Return the comparison with 90 % intervals, from the model's quick uncertainty.

    Args:
        progress: receives the share done, 0 to 1.
        at: (S,) the samples with an interval; None takes all.

    Raises:
        ModelError: the model's file is older than its calibration, and it cannot be calibrated now.
    """
    motion = comparison.motion
    at = np.arange(len(motion)) if at is None else at
    states = motion.q, motion.qd, motion.qdd
    certain = model.quick_uncertainty
    reach = certain.reach(*states, LEVEL, progress, time=motion.time, segment=motion.segment, at=at)
    inside = np.abs(comparison.residual[at]) <= reach
    seconds = int(motion.blocks(1.0)[-1]) + 1
    found = Interval(model.joints, at, reach, inside.mean(axis=0), seconds)
    return replace(comparison, interval=found)
