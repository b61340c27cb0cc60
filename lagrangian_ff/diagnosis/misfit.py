"""The error of a model on a recording, beside the error that its identification promised.

A model was judged on blocks of its training motion that were left out. Where it errs clearly more
on a recording, inside the range of motion that it knows, the arm or its measurement has changed
since.
"""

from dataclasses import dataclass

import numpy as np

from lagrangian_ff.arrays import Floats
from lagrangian_ff.diagnosis import thresholds
from lagrangian_ff.diagnosis.compare import OUTSIDE
from lagrangian_ff.identification import Model, decimated
from lagrangian_ff.kernels import States
from lagrangian_ff.recording.motion import Motion

BLOCK = 2.0  # s, longer than errors of neighbouring samples are alike
DEVIATIONS = 3.0
"""Standard deviations by which chance hardly moves an error, on any joint."""
FEWEST = 4
"""Fewest blocks from which the spread of an error is known."""


@dataclass(frozen=True)
class Misfit:
    """The errors of a model on a recording and on its own training motion, by joint.

    Attributes:
        joints: N names.
        own: (N,) N·m rms on blocks of the training motion, left out in turn; NaN if unknown.
        here: (N,) N·m rms on the recording, inside the range of the training motion; NaN if that
            is too little of it.
        whole: (N,) N·m rms on all of the recording.
        nmse: (N,) the latter squared over the variance of the torque; NaN if it did not vary.
        outside: the share of the recording outside that range.
        surely: (N,) the ratio of `here` to `own` that chance hardly exceeds; 0 if unknown.
    """

    joints: tuple[str, ...]
    own: Floats
    here: Floats
    whole: Floats
    nmse: Floats
    outside: float
    surely: Floats

    @property
    def larger(self) -> tuple[int, ...]:
        """Return the joints whose error is clearly larger than promised, the worst first."""
        order = np.argsort(-self.surely)
        return tuple(int(n) for n in order if self.surely[n] > thresholds.USED.misfit)

    @property
    def poor(self) -> tuple[int, ...]:
        """Return the joints whose torque the model misses by more than noise, the worst first."""
        order = np.argsort(-np.nan_to_num(self.nmse))
        return tuple(int(n) for n in order if self.nmse[n] > thresholds.USED.poor)

    @property
    def where(self) -> str:
        """Return in words how much of the recording is outside the range; empty if little."""
        if self.outside <= OUTSIDE:
            return ""
        return f", {self.outside:.0%} of the motion being outside the range that it knows"

    def words(self) -> str:
        """Return the joint with the most excess error, in words; empty if there is none."""
        if not self.larger:
            return ""
        n = self.larger[0]
        times = self.here[n] / self.own[n]
        return (
            f"on {self.joints[n]} its error is {self.here[n]:.3g} N·m, {times:.2g} times the "
            f"{self.own[n]:.3g} N·m of motion left out when it was identified"
        )


def misfit_of(model: Model, motion: Motion) -> Misfit:
    """Return the errors of a model on a recording beside its own.

    The spread of both over blocks of time bounds their ratio, three standard deviations down.

    Args:
        motion: measured; its joints may be more, in any order.
    """
    motion = decimated(motion.select(model.joints))
    error = _error(model, motion)
    x = States(motion.q, motion.qd, motion.qdd)
    known = (model.range.excess(x) <= OUTSIDE).all(axis=1)
    inside = motion.take(np.flatnonzero(known))
    here, spread_here = _by_blocks(inside, error[known])
    learned = model.data.take(np.flatnonzero(model.trained))
    _, spread_own = _by_blocks(learned, _error(model, learned))
    promised = model.identified.validation.by_joint
    own = np.array([promised.get(name, np.nan) for name in model.joints])
    whole, variance = np.sqrt(np.mean(error**2, axis=0)), np.var(motion.tau, axis=0)
    with np.errstate(divide="ignore", invalid="ignore"):
        # A deviation of the square is half as large of its root.
        surely = here / own * np.exp(-0.5 * DEVIATIONS * np.hypot(spread_here, spread_own))
        nmse = np.where(variance > 0.0, whole**2 / variance, np.nan)
    outside = 1.0 - float(known.mean())
    known_ratio = np.nan_to_num(surely, posinf=0.0)
    return Misfit(model.joints, own, here, whole, nmse, outside, known_ratio)


def _error(model: Model, motion: Motion) -> Floats:
    """Return (M, N) N·m that a model misses."""
    states = motion.q, motion.qd, motion.qdd
    return np.asarray(motion.tau - model.predict(*states, time=motion.time, segment=motion.segment))


def _by_blocks(motion: Motion, error: Floats) -> tuple[Floats, Floats]:
    """Return (N,) N·m rms of an error (M, N), and (N,) the relative deviation of its square."""
    nothing = np.full(error.shape[1], np.nan)
    if not len(motion):
        return nothing, nothing
    _, block = np.unique(motion.blocks(BLOCK), return_inverse=True)
    count = np.bincount(block)
    blocks = len(count)
    if blocks < FEWEST:
        return nothing, nothing
    sums = np.stack([np.bincount(block, one) for one in (error**2).T], axis=1)
    mean = sums.sum(axis=0) / len(block)
    scatter = np.sum((sums - count[:, None] * mean) ** 2, axis=0) * blocks / (blocks - 1)
    relative = np.sqrt(scatter) / len(block) / np.where(mean > 0.0, mean, np.inf)
    return np.sqrt(mean), np.asarray(relative)
