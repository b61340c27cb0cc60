"""The paper's finite-dimensional benchmarks, `motor` (54) and `pol`, and no kernel at all."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import ClassVar, TypeVar

import numpy as np
from numpy.typing import NDArray

from lagrangian_ff.kernels.base import IndependentKernel, largest, of_joint
from lagrangian_ff.kernels.states import States

Floats = NDArray[np.float64]
Self = TypeVar("Self", bound="_Finite")


@dataclass(frozen=True)
class _Finite(IndependentKernel):
    """Kernels with scales of the rates and nothing to search."""

    velocity_scale: Floats
    acceleration_scale: Floats

    per_joint: ClassVar[bool] = False

    @classmethod
    def start(cls: type[Self], x: States) -> Self:
        """Rates normalised to 1, as in section IV of the paper."""
        return cls(
            velocity_scale=np.array([1.0 / largest(x.qd)]),
            acceleration_scale=np.array([1.0 / largest(x.qdd)]),
        )

    @property
    def hyperparameters(self) -> Mapping[str, Floats]:
        """See `Kernel.hyperparameters`."""
        return {
            "velocity_scale": self.velocity_scale,
            "acceleration_scale": self.acceleration_scale,
        }

    def replace(self: Self, **hyperparameters: Floats) -> Self:
        """See `Kernel.replace`."""
        return replace(self, **hyperparameters)

    def _rates(self, x: States, joint: int) -> tuple[Floats, Floats]:
        velocity = of_joint(self.velocity_scale, joint) * x.qd
        acceleration = of_joint(self.acceleration_scale, joint) * x.qdd
        return velocity, acceleration


class Motor(_Finite):
    """The independent joint model (54): torque c1 qdd_n + c2 qd_n."""

    name = "motor"
    meaning = "each joint a motor with an inertia and a viscous loss, no coupling"

    def cross(self, x: States, u: States, joint: int) -> Floats:
        """See `IndependentKernel.cross`."""
        vx, ax = self._rates(x, joint)
        vu, au = self._rates(u, joint)
        return np.outer(vx[:, joint], vu[:, joint]) + np.outer(ax[:, joint], au[:, joint])

    def variance(self, x: States) -> Floats:
        """See `Kernel.variance`."""
        out = np.empty_like(x.q)
        for joint in range(x.joints):
            velocity, acceleration = self._rates(x, joint)
            out[:, joint] = velocity[:, joint] ** 2 + acceleration[:, joint] ** 2
        return out


class Pol(_Finite):
    """Rigid-body torques as trigonometric polynomials, the benchmark `pol`.

    (1 + qdd·qdd' + (qd·qd')²) Π_j ((1 + cos(q_j − q'_j)) / 2)²: inertia, Coriolis and gravity
    terms whose coefficients are polynomials of degree two in each cosine and sine, which holds
    every serial arm of revolute joints. The paper takes `pol` from its reference [34] without
    printing it; this is that space of functions with the plainest inner product on it.
    """

    name = "pol"
    meaning = "rigid-body terms with trigonometric polynomials as coefficients, joints apart"

    def cross(self, x: States, u: States, joint: int) -> Floats:
        """See `IndependentKernel.cross`."""
        vx, ax = self._rates(x, joint)
        vu, au = self._rates(u, joint)
        position = np.ones((len(x), len(u)))
        for n in range(x.joints):
            position *= (0.5 + 0.5 * np.cos(x.q[:, n, None] - u.q[None, :, n])) ** 2
        return (1.0 + ax @ au.T + (vx @ vu.T) ** 2) * position

    def variance(self, x: States) -> Floats:
        """See `Kernel.variance`."""
        out = np.empty_like(x.q)
        for joint in range(x.joints):
            velocity, acceleration = self._rates(x, joint)
            inertia = np.sum(acceleration**2, axis=1)
            out[:, joint] = 1.0 + inertia + np.sum(velocity**2, axis=1) ** 2
        return out


class Nothing(_Finite):
    """No Lagrangian part: torque is the basis of effects alone."""

    name = "none"
    meaning = "no Lagrangian part: the effects alone"

    def cross(self, x: States, u: States, joint: int) -> Floats:
        """See `IndependentKernel.cross`."""
        return np.zeros((len(x), len(u)))

    def variance(self, x: States) -> Floats:
        """See `Kernel.variance`."""
        return np.zeros_like(x.q)
