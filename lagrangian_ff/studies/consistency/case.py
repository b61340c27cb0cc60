"""A case: one model learns one robot from so many samples."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lagrangian_ff.studies.dof.case import error_of
from lagrangian_ff.studies.regression.learn import learn, model_of
from lagrangian_ff.studies.regression.relaxed import friction_columns
from lagrangian_ff.studies.robots.samples import Samples, Scene, draw_samples

Floats = NDArray[np.float64]

SHARP = 1e-3
"""σ_f in rad/s at which the basis (51), of those searched, comes nearest to a sharp sign."""


@dataclass(frozen=True)
class Growing:
    """A robot, a model and a number of samples.

    Attributes:
        scene: what the robot is like, and how many training samples there are.
        seed: of the study.  joints: N.  robot: its number.  model: its name.
    """

    scene: Scene
    seed: int
    joints: int
    robot: int
    model: str

    @property
    def name(self) -> str:
        """As in m0400-robot03-vrbfs+fri."""
        return f"m{self.scene.training:04d}-robot{self.robot:02d}-{self.model}"

    def run(self) -> Mapping[str, Any]:
        """Learn and ask.

        Returns:
            In the robot's unit of torque, over validation samples and joints: `error`, that of the
            torques without noise; `bound`, the right side of (50): the friction that the model's
            friction basis cannot be; what was chosen.
        """
        spec = model_of(self.model)
        samples = draw_samples(self.scene, self.seed, self.joints, self.robot)
        learned = learn(spec, samples.x, samples.tau, samples.fold, None)
        return {
            "samples": self.scene.training,
            "robot": self.robot,
            "model": self.model,
            "error": error_of(learned, samples, samples.truth),
            "bound": bound(samples, with_basis=bool(spec.effects)),
            **learned.record(),
        }


def bound(samples: Samples, *, with_basis: bool) -> float:
    """What of the friction is left when the friction basis has taken all it can, eq. (50).

    Args:
        samples: of a robot with friction.
        with_basis: whether the model has the basis (51).

    Returns:
        The root of the mean squared torque of all joints, over the validation samples.
    """
    left = samples.asked_friction
    if with_basis:
        sigma_f = np.full(samples.asked.joints, SHARP)
        columns = friction_columns(samples.asked, samples.x, sigma_f)
        left = np.stack(
            [_residual(columns[:, n], left[:, n]) for n in range(samples.asked.joints)], axis=1
        )
    return float(np.sqrt(np.mean(left**2)))


def _residual(columns: Floats, values: Floats) -> Floats:
    return np.asarray(values - columns @ np.linalg.lstsq(columns, values, rcond=None)[0])
