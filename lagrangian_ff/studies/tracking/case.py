"""One case of tracking: a feedforward learned from the first third, driven along the whole."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

from lagrangian_ff.identification import Settings, identify
from lagrangian_ff.recording.recording import Recording
from lagrangian_ff.studies.arm.drive import Drive, mean_speed
from lagrangian_ff.studies.arm.prediction import chosen_of, rms

NONE, TRUE = "none", "true"
"""The servo alone; and the plant's own torques, the bound of what feedforward can do."""


@dataclass(frozen=True)
class Tracked:
    """The arm along one trajectory with one feedforward.

    Attributes:
        drive: which arm and trajectory.
        feedforward: `none`, `true`, or a model by its kernel and effects.
        settings: of the identification but for the model.
    """

    drive: Drive
    feedforward: str
    settings: Settings

    @property
    def name(self) -> str:
        """As in `speed04-vrbfs+fri`."""
        return f"{self.drive.name}-{self.feedforward}"

    def run(self) -> Mapping[str, Any]:
        """Record with the servo alone, identify, drive with the precomputed torque.

        Returns:
            `speed`, `feedforward`; `velocity`, the mean norm of velocity with the servo alone in
            rad/s; `rmse`, the error of position on the last two thirds in rad (all joints), also
            in `joints`; and `chosen`, where there is a model.
        """
        alone = self.drive.motion()
        chosen: dict[str, Any] = {}
        if self.feedforward == NONE:
            run = self.drive.recording
        elif self.feedforward == TRUE:
            run = self.drive.run("true")
        else:
            found = identify(alone, replace(self.settings, model=self.feedforward))
            chosen = {"chosen": chosen_of(found)}
            run = self.drive.run(found.model.predict)
        error = self._error(run)
        return {
            "speed": self.drive.speed,
            "feedforward": self.feedforward,
            "velocity": mean_speed(alone),
            "rmse": float(rms(error)),
            "joints": dict(zip(alone.joints, error.tolist(), strict=True)),
            **chosen,
        }

    def _error(self, run: Recording) -> Any:
        """(6,) rad, rms on what was not learned from."""
        learned = round(self.settings.train * len(run))
        return rms(self.drive.tracking_error(run)[learned:])
