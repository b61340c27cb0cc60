"""Kernels on the Lagrangian, pushed through the Euler-Lagrange operator: the paper's own.

The Lagrangian has the universal kernel (36), on positions (38) or on their cosines and sines
(39). The vector-valued kernel (22) couples all joints through the one Lagrangian they share; its
diagonal gives the scalar kernels (30) and, with hyperparameters of each joint's own, (35).
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, ClassVar, TypeVar

import numpy as np
from numpy.typing import NDArray

from lagrangian_ff.kernels import fused
from lagrangian_ff.kernels.base import (
    Hyperparameter,
    IndependentKernel,
    Kernel,
    LagrangianKernel,
    Learned,
    largest,
    of_joint,
)
from lagrangian_ff.kernels.compiled import CompiledKernel, prepared
from lagrangian_ff.kernels.side_by_side import SideBySide
from lagrangian_ff.kernels.states import States

Floats = NDArray[np.float64]
Self = TypeVar("Self", bound="_Universal")

SIGMA = Hyperparameter(
    "sigma", "1", "squared length scale of the Lagrangian's kernel (38), (39)", 1e-2, 1e3
)
VELOCITY_SCALE = Hyperparameter(
    "velocity_scale", "s/rad", "c of (38), (39): brings velocities to the scale of positions",
    1e-1, 1e1,
)  # fmt: skip


@dataclass(frozen=True)
class _Universal(Kernel):
    """What the kernels of family (36) share: two hyperparameters and the map on positions."""

    sigma: Floats
    velocity_scale: Floats

    angles: ClassVar[bool]
    free: ClassVar[bool] = True
    searched: ClassVar[tuple[Hyperparameter, ...]] = (SIGMA, VELOCITY_SCALE)

    @classmethod
    def start(cls: type[Self], x: States) -> Self:
        """σ twice the number of joints, c = 1 / max |qd| as in the paper, section IV."""
        return cls(
            sigma=np.array([2.0 * x.joints]),
            velocity_scale=np.array([1.0 / largest(x.qd)]),
        )

    @property
    def hyperparameters(self) -> Mapping[str, Floats]:
        """See `Kernel.hyperparameters`."""
        return {"sigma": self.sigma, "velocity_scale": self.velocity_scale}

    def replace(self: Self, **hyperparameters: Floats) -> Self:
        """See `Kernel.replace`."""
        return replace(self, **hyperparameters)

    def _weights(self, joints: int, joint: int = 0) -> tuple[Any, Floats, Floats]:
        """Which coordinates are angles, α and w of `fused`, for one joint's hyperparameters."""
        alpha = 1.0 / of_joint(self.sigma, joint)
        w = alpha * of_joint(self.velocity_scale, joint) ** 2
        return np.full(joints, self.angles), np.full(joints, alpha), np.full(joints, w)


class _Vector(_Universal, CompiledKernel, LagrangianKernel):
    """The vector-valued Lagrangian kernel (22)."""

    loops: ClassVar[Any] = fused
    quadratic: ClassVar[bool] = False

    def learned(self, u: States, a: Floats) -> Learned:
        """See `Kernel.learned`; no block is formed."""
        return SideBySide.of(u, a, self._weights(u.joints))

    def lagrangian_row(self, x: States, u: States) -> Floats:
        """(M_x, M_u, N) T_m,u k_L(x, u_j), eq. (34): what recovers the Lagrangian in (31)."""
        out = np.empty((len(x), len(u), x.joints))
        fused.lagrangian_rows(prepared(x), prepared(u), *self._weights(x.joints), out)
        return out

    def lagrangian(self, x: States, u: States, a: Floats) -> Floats:
        """See `LagrangianKernel.lagrangian`."""
        return self._told(x, u, a)[0]

    def momentum(self, x: States, u: States, a: Floats) -> Floats:
        """See `LagrangianKernel.momentum`."""
        return self._told(x, u, a)[1]

    def _told(self, x: States, u: States, a: Floats) -> tuple[Floats, Floats]:
        value, momentum = np.empty(len(x)), np.empty((len(x), x.joints))
        weights, coefficients = self._weights(x.joints), np.ascontiguousarray(a)
        fused.tell_lagrangian(prepared(x), prepared(u), *weights, coefficients, value, momentum)
        return value, momentum


class _Scalar(_Universal, IndependentKernel):
    """The scalar Lagrangian kernels: the diagonal of (22), joint by joint."""

    def cross(self, x: States, u: States, joint: int) -> Floats:
        """See `IndependentKernel.cross`."""
        out = np.empty((len(x), len(u)))
        weights = self._weights(x.joints, joint)
        fused.cross_diagonal(prepared(x), prepared(u), *weights, joint, out)
        return out

    def apply(self, x: States, u: States, a: Floats) -> Floats:
        """See `Kernel.apply`."""
        out = np.empty((len(x), x.joints))
        states = prepared(x), prepared(u)
        for joint in range(x.joints):
            torque, coefficients = np.empty(len(x)), np.ascontiguousarray(a[:, joint])
            weights = self._weights(x.joints, joint)
            fused.apply_diagonal(*states, *weights, joint, coefficients, torque)
            out[:, joint] = torque
        return out

    def variance(self, x: States) -> Floats:
        """See `Kernel.variance`."""
        out = np.empty((len(x), x.joints))
        every = np.empty_like(out)
        for joint in range(x.joints):
            fused.variances(prepared(x), *self._weights(x.joints, joint), every)
            out[:, joint] = every[:, joint]
        return out


class Vrbf(_Vector):
    """Vector-valued Lagrangian kernel (22) of the rbf kernel on positions (38)."""

    name = "vrbf"
    meaning = "one Lagrangian for all joints, rbf in position and velocity"
    angles = False


class Vrbfs(_Vector):
    """Vector-valued Lagrangian kernel (22) of the rbf kernel on cosines and sines (39)."""

    name = "vrbfs"
    meaning = "one Lagrangian for all joints, rbf in the cosines and sines of revolute joints"
    angles = True


class Srbf(_Scalar):
    """Scalar Lagrangian kernels (35) of the rbf kernel on positions (38)."""

    name = "srbf"
    meaning = "a Lagrangian of its own for each joint, rbf in position and velocity"
    angles = False


class Srbfs(_Scalar):
    """Scalar Lagrangian kernels (35) of the rbf kernel on cosines and sines (39)."""

    name = "srbfs"
    meaning = "a Lagrangian of its own for each joint, rbf in the cosines and sines"
    angles = True


class Svrbf(_Scalar):
    """Scalar Lagrangian kernels (30): the diagonal of `vrbf`, one set of hyperparameters."""

    name = "svrbf"
    meaning = "the diagonal of vrbf: one Lagrangian kernel, joints learned apart"
    angles = False
    per_joint = False


class Svrbfs(_Scalar):
    """Scalar Lagrangian kernels (30): the diagonal of `vrbfs`, one set of hyperparameters."""

    name = "svrbfs"
    meaning = "the diagonal of vrbfs: one Lagrangian kernel, joints learned apart"
    angles = True
    per_joint = False
