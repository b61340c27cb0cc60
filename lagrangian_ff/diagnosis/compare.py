"""A model held against a motion: predicted and measured torque, and the error per joint."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from lagrangian_ff.diagnosis.interval import Interval, interval, quick_interval
from lagrangian_ff.identification import Model, Score
from lagrangian_ff.kernels import States
from lagrangian_ff.progress import Progress, silent
from lagrangian_ff.recording.motion import Motion

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Comparison:
    """Torques side by side.

    Attributes:
        motion: the measured motion, its joints in the model's order.
        predicted: (M, N) N·m.
        score: the error per joint.
        outside: the share of samples outside the range the model was identified on.
        interval: the 90 % intervals at some of the samples, where they were asked for.
        load: (M, N) N·m, the model's rigid-body torque; None where it was not kept.
    """

    motion: Motion
    predicted: Floats
    score: Score
    outside: float
    interval: Interval | None = None
    load: Floats | None = None

    @property
    def residual(self) -> Floats:
        """(M, N) N·m, measured minus predicted."""
        return self.motion.tau - self.predicted

    def record(self) -> dict[str, object]:
        """For JSON."""
        return {
            **self.score.record(),
            "samples": len(self.motion),
            "outside_range": self.outside,
            "source": self.motion.source,
            **(self.interval.record() if self.interval else {}),
        }


def compare(
    model: Model,
    motion: Motion,
    margin: float = 0.05,
    progress: Progress = silent,
    *,
    intervals: bool = False,
) -> Comparison:
    """Predict the torque of a motion and measure the error.

    Args:
        model: the model.
        motion: measured; may hold more joints than the model, in any order.
        margin: how far outside the identified range still counts as inside, in parts of it.
        progress: told the share done.
        intervals: whether to ask how sure the model is, too, at as many samples as a page draws.

    Raises:
        ModelError: the motion lacks a joint of the model; names both lists.
    """
    model.require_joints(motion.joints, motion.source)
    motion = motion.select(model.joints)
    inputs = model.inputs(
        motion.q, motion.qd, motion.qdd, progress, time=motion.time, segment=motion.segment
    )
    predicted = model.torque(inputs)
    excess = model.range.excess(States.of(motion.q, motion.qd, motion.qdd))
    return Comparison(
        motion,
        predicted,
        Score.of(model.joints, motion.tau, predicted),
        float(np.mean(np.any(excess > margin, axis=1))),
        quick_interval(model, motion, predicted) if intervals else None,
        inputs.load,
    )


def with_intervals(model: Model, comparison: Comparison, progress: Progress = silent) -> Comparison:
    """The same comparison with the interval of every sample.

    Args:
        model: that was compared.
        comparison: of it with a motion.
        progress: told the share done.

    Raises:
        ModelError: see `interval`.
    """
    found = interval(model, comparison.motion, comparison.predicted, progress=progress)
    return replace(comparison, interval=found)
