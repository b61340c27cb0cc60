"""The kernels without structure that the paper compares with: `rbf` (52) and `rbfs` (53)."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import ClassVar, TypeVar

import numpy as np
import scipy
from numpy.typing import NDArray

from lagrangian_ff.kernels.base import Hyperparameter, IndependentKernel, largest, of_joint
from lagrangian_ff.kernels.states import States

Floats = NDArray[np.float64]
Self = TypeVar("Self", bound="Rbf")


@dataclass(frozen=True)
class Rbf(IndependentKernel):
    """exp(−‖x − u‖² / 2σ) on positions and normalised rates, eq. (52)."""

    sigma: Floats
    velocity_scale: Floats
    acceleration_scale: Floats

    name: ClassVar[str] = "rbf"
    free: ClassVar[bool] = True
    meaning: ClassVar[str] = "any smooth function of state, each joint learned apart"
    searched: ClassVar[tuple[Hyperparameter, ...]] = (
        Hyperparameter("sigma", "1", "squared length scale of (52), (53)", 1e-2, 1e3),
    )

    @classmethod
    def start(cls: type[Self], x: States) -> Self:
        """σ three times the number of joints; rates normalised to 1, as in section IV."""
        return cls(
            sigma=np.array([3.0 * x.joints]),
            velocity_scale=np.array([1.0 / largest(x.qd)]),
            acceleration_scale=np.array([1.0 / largest(x.qdd)]),
        )

    @property
    def hyperparameters(self) -> Mapping[str, Floats]:
        """See `Kernel.hyperparameters`."""
        return {
            "sigma": self.sigma,
            "velocity_scale": self.velocity_scale,
            "acceleration_scale": self.acceleration_scale,
        }

    def replace(self: Self, **hyperparameters: Floats) -> Self:
        """See `Kernel.replace`."""
        return replace(self, **hyperparameters)

    def _position(self, q: Floats) -> Floats:
        return q

    def _features(self, x: States, joint: int) -> Floats:
        velocity = of_joint(self.velocity_scale, joint) * x.qd
        acceleration = of_joint(self.acceleration_scale, joint) * x.qdd
        return np.hstack([self._position(x.q), velocity, acceleration])

    def cross(self, x: States, u: States, joint: int) -> Floats:
        """See `IndependentKernel.cross`."""
        squared = scipy.spatial.distance.cdist(
            self._features(x, joint), self._features(u, joint), "sqeuclidean"
        )
        return np.exp(-squared / (2.0 * of_joint(self.sigma, joint)))

    def variance(self, x: States) -> Floats:
        """See `Kernel.variance`."""
        return np.ones_like(x.q)


class Rbfs(Rbf):
    """The same on the cosines and sines of positions, eq. (53), third norm squared too."""

    name = "rbfs"
    meaning = "any smooth function of state, periodic in position, each joint learned apart"

    def _position(self, q: Floats) -> Floats:
        return np.hstack([np.cos(q), np.sin(q)])
