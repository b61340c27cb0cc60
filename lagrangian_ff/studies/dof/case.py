"""A case: one model learns one robot, and is asked about states it has not seen."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lagrangian_ff.studies.regression.learn import Learned, learn, model_of
from lagrangian_ff.studies.robots.samples import Samples, Scene, draw_samples

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Learning:
    """A robot and a model.

    Attributes:
        scene: what the robot is like, and how many samples there are.
        gamma: γ of (42); None chooses it.
        seed: of the study.  joints: N.  robot: its number.  model: its name.
    """

    scene: Scene
    gamma: float | None
    seed: int
    joints: int
    robot: int
    model: str

    @property
    def name(self) -> str:
        """As in n6-robot03-vrbfs."""
        return f"n{self.joints}-robot{self.robot:02d}-{self.model}"

    def run(self) -> Mapping[str, Any]:
        """Learn and ask.

        Returns:
            `error`, the root of the mean squared error over validation samples and joints,
            N^-1/2 ‖y − f‖ of section IV-A, in the robot's `unit` of torque, N·m; `spread`, that of
            the torques themselves; what was chosen; and in a robot with friction, of a model with
            `fri`, `frictionless`: the error of the same kernel with the same numbers and noise
            where there is no friction.
        """
        spec = model_of(self.model)
        samples = draw_samples(self.scene, self.seed, self.joints, self.robot)
        learned = learn(spec, samples.x, samples.tau, samples.fold, self.gamma)
        found = {
            "joints": self.joints,
            "robot": self.robot,
            "model": self.model,
            "error": error_of(learned, samples, samples.truth),
            "spread": float(np.std(samples.truth)),
            "unit": samples.unit,
            **learned.record(),
        }
        if self.scene.friction and spec.effects:
            bare = learned.without_friction(samples.tau - samples.friction)
            found["frictionless"] = error_of(bare, samples, samples.truth - samples.asked_friction)
        return found


def error_of(learned: Learned, samples: Samples, truth: Floats) -> float:
    """Root of the mean squared error of what is learned, over validation samples and joints.

    Args:
        truth: (V, N) torques at the validation samples, in the samples' unit.
    """
    error = learned.torque(samples.asked) - truth
    return float(np.sqrt(np.mean(error**2)))
