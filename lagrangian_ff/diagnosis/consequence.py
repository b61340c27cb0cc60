"""The change of a model's error when an effect is added, and whether adding it is worth it."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from lagrangian_ff.arrays import Floats, Ints
from lagrangian_ff.diagnosis.compare import compare
from lagrangian_ff.identification import Model
from lagrangian_ff.recording.motion import Motion
from lagrangian_ff.recording.recording import columns_of

BLOCK_SECONDS = 3.0
SURELY = 2.0
"""Deviations over blocks by which an error rises at the least, for a confirmed effect to go."""


@dataclass(frozen=True, eq=False)
class Consequence:
    """The consequence of adding one finding to the model and the findings before it.

    Attributes:
        model: with the finding.
        joint: of those that the finding acts on, the one whose error changes most, relatively.
        time: (B,) s since the beginning, start of each block in which that joint moves.
        before, after: (B,) N·m, its rms error in each block of the hold-out motion.
        whole_before, whole_after: N·m, its error over the whole motion.
        every_before, every_after: N·m, over the whole motion and all joints.
        fall: of the squared error, relative to that error before; the mean of the joints that the
            finding acts on.
        deviation: of the fall, over blocks.
        rise: of the error over all joints, as the mean of its relative changes, relative to its
            deviation over blocks; negative if it falls.
        rise_in_torque: the same of the squared error in N·m, which the largest joint decides.
        joints_before, joints_after: N·m, over the whole motion, by joint name.
        beside: the consequence of adding it to all others, those after it too, where that decides
            whether it is worth it; else None.
    """

    model: Model
    joint: str
    time: Floats
    before: Floats
    after: Floats
    whole_before: float
    whole_after: float
    every_before: float
    every_after: float
    fall: float = 0.0
    deviation: float = 0.0
    rise: float = 0.0
    rise_in_torque: float = 0.0
    joints_before: Mapping[str, float] = field(default_factory=dict)
    joints_after: Mapping[str, float] = field(default_factory=dict)
    beside: "Consequence | None" = None

    @property
    def worth(self) -> bool:
        """Return whether the error surely falls on its joints, and does not rise over all.

        A small joint counts as much there as a large one. Each refit moves the largest joint's
        error a little, so that in N·m only a sure rise counts.
        """
        if self.beside is not None:
            return self.beside.worth
        return self.fall > self.deviation and self.rise <= 1.0 and self.rise_in_torque <= SURELY

    @property
    def harms(self) -> bool:
        """Return whether the error surely rises, on its joints or over all of them."""
        if self.beside is not None:
            return self.beside.harms
        rise = max(self.rise, self.rise_in_torque)
        return self.fall < -SURELY * self.deviation or rise > SURELY

    @property
    def raised(self) -> str:
        """Return the joint whose error rises most, relatively; empty if that of none does."""
        rise = {n: self.joints_after[n] / b for n, b in self.joints_before.items() if b > 0.0}
        worst = max(rise, key=lambda name: rise[name], default="")
        return worst if worst and rise[worst] > 1.0 else ""


def errors_of(model: Model, motion: Motion) -> Floats:
    """Return (M, N) N·m that a model misses; NaN where a joint rests that moves elsewhere.

    There its torque is anywhere within static friction, and no model is better than another.
    """
    rests = motion.rest[:, columns_of(model.joints, motion.joints, motion.source)]
    return np.where(rests & ~rests.all(axis=0), np.nan, compare(model, motion).residual)


def rms(error: Floats) -> float:
    """Return the root mean square of errors, those left out that are NaN."""
    return float(np.sqrt(np.nanmean(error**2)))


def by_joint(model: Model, error: Floats) -> dict[str, float]:
    """Return the root mean square of errors (M, N) of each joint, by its name."""
    return dict(zip(model.joints, map(rms, error.T), strict=True))


def consequence_of(
    model: Model, motion: Motion, joints: Sequence[str], before: Floats, after: Floats
) -> Consequence:
    """Return the consequence with a larger model, of `errors_of` (M, N) before and after.

    Args:
        joints: names of those that the finding acts on.
    """
    own = [model.joints.index(joint) for joint in joints]
    starts = np.flatnonzero(np.diff(motion.blocks(BLOCK_SECONDS), prepend=-1))
    counts = np.add.reduceat(np.isfinite(before).astype(np.int64), starts)
    squares = [np.add.reduceat(np.nan_to_num(error) ** 2, starts) for error in (before, after)]
    whole = squares[0].sum(axis=0)
    rise = squares[1] - squares[0]
    relative = np.divide(rise, whole, out=np.zeros_like(rise), where=whole > 0.0)
    every, tiny = counts.sum(axis=1), np.finfo(np.float64).tiny
    risen, in_torque = (
        float(one.sum()) / max(_deviation(one, every), tiny)
        for one in (relative.sum(axis=1), rise.sum(axis=1))
    )
    column = max(own, key=lambda n: abs(float(relative[:, n].sum())))
    kept = counts[:, column] > 0
    old, new = (np.sqrt(one[kept, column] / counts[kept, column]) for one in squares)
    falls, moves = -relative[:, own].mean(axis=1), counts[:, own].sum(axis=1)
    return Consequence(
        model,
        model.joints[column],
        motion.elapsed[starts[kept]],
        old,
        new,
        rms(before[:, column]),
        rms(after[:, column]),
        rms(before),
        rms(after),
        float(falls.sum()),
        _deviation(falls[moves > 0], moves[moves > 0]),
        risen,
        in_torque,
        by_joint(model, before),
        by_joint(model, after),
    )


def _deviation(parts: Floats, counts: Ints) -> float:
    """Return the standard deviation of the sum of blocks' parts, for their numbers of samples."""
    scatter = float(np.sum((parts - counts * parts.sum() / counts.sum()) ** 2))
    return float(np.sqrt(scatter * len(parts) / max(1, len(parts) - 1)))
