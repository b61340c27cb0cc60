"""One case of torque prediction: a model learned from the first third, judged on the rest."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from lagrangian_ff.identification import Identification, Settings, identify
from lagrangian_ff.studies.arm.drive import Drive, mean_speed


@dataclass(frozen=True)
class Prediction:
    """A model of the arm along one trajectory.

    Attributes:
        drive: where the data come from.
        model: kernel and effects.
        settings: of the identification but for the model.
    """

    drive: Drive
    model: str
    settings: Settings

    @property
    def name(self) -> str:
        """As in `speed04-vrbfs+fri`."""
        return f"{self.drive.name}-{self.model}"

    def run(self) -> Mapping[str, Any]:
        """Identify and judge.

        Returns:
            `speed`, `loaded`, `model`; `velocity`, the mean norm of velocity in rad/s; `rmse`, the
            error on the last two thirds in N·m (all joints), `relative`, over the torque's own rms
            there, both also in `joints`; and `chosen`.
        """
        motion = self.drive.motion()
        found = identify(motion, replace(self.settings, model=self.model))
        measured = found.held_out.tau
        error = rms(measured - found.predicted)
        torque = rms(measured)
        return {
            "speed": self.drive.speed,
            "loaded": self.drive.loaded,
            "model": self.model,
            "velocity": mean_speed(motion),
            "rmse": float(rms(error)),
            "relative": float(rms(error) / rms(torque)),
            "joints": {
                joint: {"rmse": float(e), "relative": float(e / t)}
                for joint, e, t in zip(motion.joints, error, torque, strict=True)
            },
            "chosen": chosen_of(found),
        }


def chosen_of(found: Identification) -> dict[str, object]:
    """What the data chose: the kernel, how torques are scaled, and every hyperparameter."""
    return {key: found.record[key] for key in ("model", "scale", "hyperparameters")}


def rms(values: Any) -> Any:
    """Root mean square over the first axis."""
    return np.sqrt(np.mean(np.square(values), axis=0))
