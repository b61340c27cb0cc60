"""The samples that hyperparameters are chosen on."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from lagrangian_ff.effects import Inputs
from lagrangian_ff.identification.samples import evenly, groups
from lagrangian_ff.kernels import States

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


@dataclass(frozen=True)
class TrainingSet:
    """What hyperparameters are chosen on.

    Attributes:
        x: (M, N) as effects see it.  tau: (M, N) N·m.
        fold: (M,) the fold each sample is left out with.
        trust: (M, N) in each torque, for the fits and for what they are judged by; None trusts all.
    """

    x: Inputs
    tau: Floats
    fold: Ints
    trust: Floats | None = None

    def thinned(self, samples: int) -> "TrainingSet":
        """At most this many samples, evenly spread."""
        index = evenly(len(self.x), samples)
        trust = None if self.trust is None else self.trust[index]
        return replace(
            self, x=self.x.take(index), tau=self.tau[index], fold=self.fold[index], trust=trust
        )

    @property
    def states(self) -> States:
        """(M, N)."""
        return States(self.x.q, self.x.qd, self.x.qdd)

    def groups(self) -> list[Ints]:
        """The samples of each fold."""
        return groups(self.fold)
