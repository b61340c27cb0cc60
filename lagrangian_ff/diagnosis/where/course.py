"""What the error of a model is looked at against: the motion, its load, and what is known of it."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from lagrangian_ff.diagnosis.where.resampling import BLOCK_SECONDS, FEWEST_BLOCKS
from lagrangian_ff.recording.motion import Motion

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Course:
    """A measured motion beside what the model says of it.

    Attributes:
        motion: M samples of N joints.
        residual: (M, N) N·m, measured minus predicted.
        load: (M, N) N·m, the model's rigid-body torque: never the measured one, which holds the
            residual.
        excess: (M,) how far outside the identified range the state is, in parts of the range.
    """

    motion: Motion
    residual: Floats
    load: Floats
    excess: Floats

    @property
    def too_short(self) -> bool:
        """Whether there are too few blocks to tell anything from chance."""
        blocks = self.motion.blocks(BLOCK_SECONDS)
        return not len(blocks) or int(blocks[-1]) + 1 < FEWEST_BLOCKS

    def thinned(self, most: int) -> "Course":
        """At most so many samples, evenly spread."""
        step = -(-len(self.motion) // most)
        if step <= 1:
            return self
        part = slice(None, None, step)
        return replace(
            self,
            motion=self.motion.take(part),
            residual=self.residual[part],
            load=self.load[part],
            excess=self.excess[part],
        )
