"""The change of a model's error when an effect is added, and whether adding it is worth it."""

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from lagrangian_ff.arrays import Floats
from lagrangian_ff.diagnosis.compare import compare
from lagrangian_ff.identification import Model
from lagrangian_ff.recording.motion import Motion
from lagrangian_ff.recording.recording import columns_of

BLOCK_SECONDS = 3.0


@dataclass(frozen=True, eq=False)
class Consequence:
    """The consequence of adding one finding to the model and the findings before it.

    Attributes:
        model: with the finding.
        time: (B,) s since the beginning, start of each block in which the joint moves.
        before, after: (B,) N·m, rms error of the joint in each block of the hold-out motion.
        whole_before, whole_after: N·m, over the whole motion.
        every_before, every_after: N·m, over the whole motion and all joints.
        deviation: of the fall of the joint's squared error, relative to that error before, over
            blocks.
        joints_before, joints_after: N·m, over the whole motion, by joint name.
        beside: the consequence of adding it to all others, those after it too, where that decides
            whether it is worth it; else None.
    """

    model: Model
    time: Floats
    before: Floats
    after: Floats
    whole_before: float
    whole_after: float
    every_before: float
    every_after: float
    deviation: float = 0.0
    joints_before: Mapping[str, float] = field(default_factory=dict)
    joints_after: Mapping[str, float] = field(default_factory=dict)
    beside: "Consequence | None" = None

    @property
    def worth(self) -> bool:
        """Return whether the error falls: surely on its joint, and over all of them.

        Over all joints it must not rise in N·m, nor in the mean of its relative changes: a small
        joint counts as much as a large one.
        """
        if self.beside is not None:
            return self.beside.worth
        if not self.whole_before > 0.0:
            return False
        fall = 1.0 - (self.whole_after / self.whole_before) ** 2
        pairs = [(b, self.joints_after[name]) for name, b in self.joints_before.items()]
        each = [float(np.log(after / before)) for before, after in pairs if before > 0.0 < after]
        return fall > self.deviation and self.every_after < self.every_before and sum(each) <= 0.0

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
    model: Model, motion: Motion, joint: str, before: Floats, after: Floats
) -> Consequence:
    """Return the consequence with a larger model, of `errors_of` (M, N) before and after."""
    column = model.joints.index(joint)
    starts = np.flatnonzero(np.diff(motion.blocks(BLOCK_SECONDS), prepend=-1))
    moves = np.add.reduceat(np.isfinite(before[:, column]).astype(np.int64), starts)
    kept = moves > 0
    counts = moves[kept]

    def by_block(error: Floats) -> Floats:
        sums = np.add.reduceat(np.nan_to_num(error[:, column]) ** 2, starts)[kept]
        return np.asarray(np.sqrt(sums / counts))

    blocks = by_block(before), by_block(after)
    whole = rms(before[:, column]), rms(after[:, column])
    falls = (blocks[0] ** 2 - blocks[1] ** 2) * counts
    scatter = float(np.sum((falls - counts * falls.sum() / counts.sum()) ** 2))
    scatter *= len(counts) / max(1, len(counts) - 1)
    squares = float(np.nansum(before[:, column] ** 2))
    return Consequence(
        model,
        motion.elapsed[starts[kept]],
        *blocks,
        *whole,
        rms(before),
        rms(after),
        float(np.sqrt(scatter)) / squares if squares > 0.0 else 0.0,
        by_joint(model, before),
        by_joint(model, after),
    )
