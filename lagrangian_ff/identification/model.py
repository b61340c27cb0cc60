"""The identified model: torques, uncertainty, mechanics and its file."""

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING

from lagrangian_ff.identification import storage
from lagrangian_ff.identification.history import Step
from lagrangian_ff.identification.predicting import TorqueModel
from lagrangian_ff.identification.records import Identified
from lagrangian_ff.kernels.constrained import Linkage

if TYPE_CHECKING:
    from lagrangian_ff.identification.certainty.uncertainty import Uncertainty
    from lagrangian_ff.identification.mechanics.dynamics import Dynamics


@dataclass(frozen=True)
class Model(TorqueModel):
    """An identified model; its attributes are those of `TorqueModel`."""

    @cached_property
    def identified(self) -> Identified:
        """Return the findings of its identification, which its record holds."""
        return Identified.from_record(self.record)

    @cached_property
    def history(self) -> tuple[Step, ...]:
        """Return the steps that made it."""
        return tuple(map(Step.from_record, self.steps))

    @cached_property
    def dynamics(self) -> "Dynamics":
        """Return mass matrix, energies and forward dynamics.

        Raises:
            ModelError: the joints share no Lagrangian.
        """
        from lagrangian_ff.identification.mechanics.dynamics import Dynamics

        return Dynamics(self)

    @cached_property
    def uncertainty(self) -> "Uncertainty":
        """Return variances and intervals of its torques.

        The first use solves the model again from the data that it keeps, which takes as long as in
        identification, hyperparameters given.
        """
        from lagrangian_ff.identification.certainty.uncertainty import Uncertainty

        return Uncertainty.of(self)

    @cached_property
    def quick_uncertainty(self) -> "Uncertainty":
        """Return the same from 100 of the samples, calibrated during identification: at once.

        Files of older versions without a calibration take as long as `uncertainty`.

        Raises:
            ModelError: there is no calibration, and the training motion is too short for one.
        """
        from lagrangian_ff.identification.certainty.uncertainty import Uncertainty

        return Uncertainty.quick(self)

    def save(self, path: "str | Path") -> None:
        """Write the model to a file; see `storage`."""
        storage.save(self, Path(path))

    @classmethod
    def load(cls, path: "str | Path", linkage: Linkage | None = None) -> "Model":
        """Read a model from a file; see `storage`.

        Args:
            linkage: of a model whose loops are closed.

        Raises:
            ModelError: there is no such file, it is damaged, no model, or of a newer version.
        """
        return storage.load(cls, Path(path), linkage)
