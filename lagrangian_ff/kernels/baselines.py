"""The kernels that the paper compares with, `rbf`, `rbfs`, `motor` and `pol`, and `none`."""

from dataclasses import dataclass
from typing import ClassVar, TypeVar

import numpy as np
import scipy

from lagrangian_ff.arrays import Floats
from lagrangian_ff.kernels.base import Hyperparameter, IndependentKernel, largest, of_joint
from lagrangian_ff.kernels.states import States

Self = TypeVar("Self", bound="_Rated")


@dataclass(frozen=True)
class _Rated(IndependentKernel):
    """A kernel on velocities and accelerations that are scaled to 1, as in section IV."""

    velocity_scale: Floats
    acceleration_scale: Floats

    per_joint = False

    @classmethod
    def start(cls: type[Self], x: States) -> Self:
        return cls(np.array([1.0 / largest(x.qd)]), np.array([1.0 / largest(x.qdd)]))

    def _rates(self, x: States, joint: int) -> tuple[Floats, Floats]:
        velocity = of_joint(self.velocity_scale, joint) * x.qd
        acceleration = of_joint(self.acceleration_scale, joint) * x.qdd
        return velocity, acceleration


@dataclass(frozen=True)
class Rbf(IndependentKernel):
    """exp(−‖x − u‖² / 2σ) on positions and normalised rates, eq. (52)."""

    sigma: Floats
    velocity_scale: Floats
    acceleration_scale: Floats

    name = "rbf"
    free = True
    meaning = "any smooth function of state, each joint learned apart"
    searched: ClassVar[tuple[Hyperparameter, ...]] = (
        Hyperparameter("sigma", "1", "squared length scale of (52), (53)", 1e-2, 1e3),
    )

    @classmethod
    def start(cls, x: States) -> "Rbf":
        """Return σ three times the number of joints; rates normalised to 1, as in section IV."""
        return cls(
            sigma=np.array([3.0 * x.joints]),
            velocity_scale=np.array([1.0 / largest(x.qd)]),
            acceleration_scale=np.array([1.0 / largest(x.qdd)]),
        )

    def _position(self, q: Floats) -> Floats:
        return q

    def _features(self, x: States, joint: int) -> Floats:
        velocity = of_joint(self.velocity_scale, joint) * x.qd
        acceleration = of_joint(self.acceleration_scale, joint) * x.qdd
        return np.hstack([self._position(x.q), velocity, acceleration])

    def cross(self, x: States, u: States, joint: int) -> Floats:
        squared = scipy.spatial.distance.cdist(
            self._features(x, joint), self._features(u, joint), "sqeuclidean"
        )
        return np.exp(-squared / (2.0 * of_joint(self.sigma, joint)))

    def variance(self, x: States) -> Floats:
        return np.ones_like(x.q)


class Rbfs(Rbf):
    """As `Rbf`, on the cosines and sines of positions, eq. (53), third norm squared too."""

    name = "rbfs"
    meaning = "any smooth function of state, periodic in position, each joint learned apart"

    def _position(self, q: Floats) -> Floats:
        return np.hstack([np.cos(q), np.sin(q)])


class Motor(_Rated):
    """The independent joint model (54): torque c1 qdd_n + c2 qd_n."""

    name = "motor"
    separates = True
    meaning = "each joint a motor with an inertia and a viscous loss, no coupling"

    def cross(self, x: States, u: States, joint: int) -> Floats:
        vx, ax = self._rates(x, joint)
        vu, au = self._rates(u, joint)
        return np.outer(vx[:, joint], vu[:, joint]) + np.outer(ax[:, joint], au[:, joint])

    def variance(self, x: States) -> Floats:
        out = np.empty_like(x.q)
        for joint in range(x.joints):
            velocity, acceleration = self._rates(x, joint)
            out[:, joint] = velocity[:, joint] ** 2 + acceleration[:, joint] ** 2
        return out


class Pol(_Rated):
    """Rigid-body torques as trigonometric polynomials, the benchmark `pol`.

    (1 + qdd·qdd' + (qd·qd')²) Π_j ((1 + cos(q_j − q'_j)) / 2)²: inertia, Coriolis and gravity
    terms whose coefficients are polynomials of degree two in each cosine and sine, which holds
    every serial arm of revolute joints. The paper takes `pol` from its reference [34] without
    printing it; this is that space of functions with the plainest inner product on it.
    """

    name = "pol"
    meaning = "rigid-body terms with trigonometric polynomials as coefficients, joints apart"

    def cross(self, x: States, u: States, joint: int) -> Floats:
        vx, ax = self._rates(x, joint)
        vu, au = self._rates(u, joint)
        position = np.ones((len(x), len(u)))
        for n in range(x.joints):
            position *= (0.5 + 0.5 * np.cos(x.q[:, n, None] - u.q[None, :, n])) ** 2
        return (1.0 + ax @ au.T + (vx @ vu.T) ** 2) * position

    def variance(self, x: States) -> Floats:
        out = np.empty_like(x.q)
        for joint in range(x.joints):
            velocity, acceleration = self._rates(x, joint)
            inertia = np.sum(acceleration**2, axis=1)
            out[:, joint] = 1.0 + inertia + np.sum(velocity**2, axis=1) ** 2
        return out


class Nothing(_Rated):
    """The zero kernel: torque is the basis of effects alone."""

    name = "none"
    separates = True
    meaning = "no Lagrangian part: the effects alone"

    def cross(self, x: States, u: States, joint: int) -> Floats:
        return np.zeros((len(x), len(u)))

    def variance(self, x: States) -> Floats:
        return np.zeros_like(x.q)
