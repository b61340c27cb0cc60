"""What a model is made from, before it is solved."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lagrangian_ff.effects import Inputs
from lagrangian_ff.identification.basis import Basis
from lagrangian_ff.identification.choice import Choice, Scaling
from lagrangian_ff.identification.choosing.training import TrainingSet
from lagrangian_ff.identification.model import Model
from lagrangian_ff.identification.samples import evenly, groups
from lagrangian_ff.identification.settings import Settings
from lagrangian_ff.identification.solving.robust import doubted
from lagrangian_ff.recording.motion import Motion

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Bools = NDArray[np.bool_]

FEW = 500
"""Samples that shapes and noise are searched on where the model is on landmarks."""
INDEPENDENT_SECONDS = 1.0
"""Samples closer than this are not counted as independent when intervals are made."""


@dataclass(frozen=True)
class Blueprint:
    """All that a model is made from.

    Attributes:
        name: kernel and effects.
        choice: the hyperparameters.  scaling: of the torques.  basis: the effects' terms.
        data: the motion learned from and that held out, at the rate that is kept.
        trained: (K,) which of its samples may be learned from.
        index: (C,) those the kernel is built on.
        seen: (S,) those that determine the coefficients; the same where the fit is exact.
        settings: how all this was chosen.
        trust: (S, N) in each torque of `seen`, which Huber's loss begins with; None for squares.
    """

    name: str
    choice: Choice
    scaling: Scaling
    basis: Basis
    data: Motion
    trained: Bools
    index: Ints
    seen: Ints
    settings: Settings
    trust: Floats | None = None

    @classmethod
    def of(cls, model: Model) -> "Blueprint":
        """What a model was made from.

        Raises:
            ModelError: its record tells settings that cannot be.
        """
        return cls(
            name=model.name,
            choice=Choice(model.kernel, model.noise, {}),
            scaling=Scaling(model.unit, model.noise_share),
            basis=model.basis,
            data=model.data,
            trained=model.trained,
            index=model.index,
            seen=model.seen,
            settings=Settings.from_record(model.record.get("settings", {})),
            trust=model.trust,
        )

    @property
    def exact(self) -> bool:
        """Whether the kernel is built on all that is learned from."""
        return np.array_equal(self.index, self.seen)

    def few(self, inputs: Inputs, most: int | None = None) -> TrainingSet:
        """Samples for what is searched, few enough for an exact fit; outliers hardly count.

        Args:
            inputs: all of the data as effects see it.
            most: how many there are at most.
        """
        at = np.arange(len(self.seen)) if self.exact else evenly(len(self.seen), FEW)
        at = at if most is None else at[evenly(len(at), most)]
        index = self.seen[at]
        trust = None if self.trust is None else doubted(self.trust[at])
        return TrainingSet(inputs.take(index), self.data.tau[index], self.folds(index), trust)

    def blocks(self, samples: Ints) -> Ints:
        """(F,) the block of time each of some training samples lies in, counted from 0."""
        training = self.data.take(self.trained)
        block = np.full(len(self.data), -1)
        block[self.trained] = training.blocks(self.settings.block_seconds)
        return np.asarray(np.unique(block[samples], return_inverse=True)[1], dtype=np.int64)

    def folds(self, samples: Ints) -> Ints:
        """(F,) the fold each of some training samples is left out with."""
        return self.blocks(samples) % self.settings.folds

    @property
    def folded(self) -> list[Ints]:
        """The samples learned from, fold by fold."""
        return groups(self.folds(self.seen))

    @property
    def apart(self) -> list[Ints]:
        """The samples learned from, in the smallest groups that a fit can be asked without.

        Blocks of time, one by one; with a kernel on landmarks the folds, which alone are summed.
        """
        return groups(self.blocks(self.seen)) if self.exact else self.folded

    @property
    def seconds(self) -> Ints:
        """(S,) the second each sample learned from lies in: what is counted as independent."""
        return np.asarray(self.data.blocks(INDEPENDENT_SECONDS)[self.seen])
