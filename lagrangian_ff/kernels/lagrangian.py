"""Kernels on the Lagrangian, pushed through the Euler-Lagrange operator: the paper's own.

The Lagrangian has the universal kernel (36), on positions (38) or on their cosines and sines
(39). The vector-valued kernel (22) couples all joints through the one Lagrangian they share; its
diagonal gives the scalar kernels (30) and, with hyperparameters of each joint's own, (35).
"""

from dataclasses import dataclass
from typing import ClassVar, TypeVar

import numpy as np

from lagrangian_ff.arrays import Floats
from lagrangian_ff.kernels import base, threads
from lagrangian_ff.kernels.states import States, prepared
from lagrangian_ff.loops import loop

Self = TypeVar("Self", bound="_Universal")

SIGMA = base.Hyperparameter(
    "sigma", "1", "squared length scale of the Lagrangian's kernel (38), (39)", 1e-2, 1e3
)
_SCALE = "c of (38), (39): brings velocities to the scale of positions"
VELOCITY_SCALE = base.Hyperparameter("velocity_scale", "s/rad", _SCALE, 1e-1, 1e1)


@dataclass(frozen=True)
class _Universal(base.Kernel):
    """A kernel of the family (36): two hyperparameters and the map on positions."""

    sigma: Floats
    velocity_scale: Floats

    angles: ClassVar[bool]
    free = True
    searched: ClassVar[tuple[base.Hyperparameter, ...]] = (SIGMA, VELOCITY_SCALE)

    @classmethod
    def start(cls: type[Self], x: States) -> Self:
        """Return σ twice the number of joints, c = 1 / max |qd| as in the paper, section IV."""
        return cls(
            sigma=np.array([2.0 * x.joints]), velocity_scale=np.array([1.0 / base.largest(x.qd)])
        )

    def numbers(self, joints: int, joint: int = 0) -> tuple[int, int, Floats, Floats]:
        """Return the joints, whether they are angles, α and w of `universal.c`, for one joint."""
        alpha = 1.0 / base.of_joint(self.sigma, joint)
        w = alpha * base.of_joint(self.velocity_scale, joint) ** 2
        return joints, int(self.angles), np.full(joints, alpha), np.full(joints, w)


class _Vector(_Universal, base.LagrangianKernel):
    """The vector-valued Lagrangian kernel (22)."""

    quadratic = False

    def gram(self, x: States) -> Floats:
        states = prepared(x)
        return self._blocks(states, states, lower=True)

    def cross(self, x: States, u: States) -> Floats:
        return self._blocks(prepared(x), prepared(u), lower=False)

    def _blocks(self, x: Floats, u: Floats, lower: bool) -> Floats:
        joints, many = x.shape[2], len(u)
        out = np.empty((len(x), joints, many, joints))
        numbers = self.numbers(joints)

        def write(rows: slice) -> None:
            ends = np.array([rows.start, rows.stop])
            loop("universal_blocks")(*numbers, x, u, ends, many, lower, out[rows])

        threads.over_rows(write, len(x), len(x) * many, lower=lower)
        return out.reshape(len(x) * joints, many * joints)

    def apply(self, x: States, u: States, a: Floats) -> Floats:
        return self.learned(u, a).torque(x)

    def learned(self, u: States, a: Floats) -> base.Learned:
        return Centres.of(u, a, self.numbers(u.joints))

    def variance(self, x: States) -> Floats:
        out = np.empty((len(x), x.joints))
        loop("universal_variance")(*self.numbers(x.joints), prepared(x), len(x), out)
        return out

    def lagrangian_row(self, x: States, u: States) -> Floats:
        """Return (M_x, M_u, N) T_m,u k_L(x, u_j), eq. (34), which recovers the Lagrangian (31)."""
        out = np.empty((len(x), len(u), x.joints))
        states = prepared(x), len(x), prepared(u), len(u)
        loop("universal_lagrangian_rows")(*self.numbers(x.joints), *states, out)
        return out

    def lagrangian(self, x: States, u: States, a: Floats) -> Floats:
        return self._lagrangian(x, u, a)[0]

    def momentum(self, x: States, u: States, a: Floats) -> Floats:
        return self._lagrangian(x, u, a)[1]

    def _lagrangian(self, x: States, u: States, a: Floats) -> tuple[Floats, Floats]:
        value, momentum = np.empty(len(x)), np.empty((len(x), x.joints))
        states = prepared(x), len(x), prepared(u), len(u), np.ascontiguousarray(a)
        loop("universal_lagrangian")(*self.numbers(x.joints), *states, value, momentum)
        return value, momentum


TILE = 32
"""Centres in a SIMD tile of the loops of `centres.c`."""

PAIRS_A_BLOCK = 40
"""Pairs there that cost as much as one pair that `threads` counts."""


@dataclass(frozen=True)
class Centres(base.Learned):
    """Torques learned at centres that are stored joint by joint, for SIMD loops.

    Attributes:
        centres: (C / L, N, 5, L) of each the sine and cosine of the position, or it and 1 where the
            coordinate is linear, and qd, qdd and a.
        numbers: joints, whether they are angles, α and w of `universal.c`.
    """

    centres: Floats
    numbers: tuple[int, int, Floats, Floats]

    @classmethod
    def of(cls, u: States, a: Floats, numbers: tuple[int, int, Floats, Floats]) -> "Centres":
        """Return the torques learned at u (C, N) with coefficients a (C, N)."""
        place = (np.sin(u.q), np.cos(u.q)) if numbers[1] else (u.q, np.ones_like(u.q))
        parts = -(-len(u) // TILE)
        centres = np.zeros((5, parts * TILE, u.joints))
        centres[:, : len(u)] = *place, u.qd, u.qdd, a
        tiles = centres.reshape(5, parts, TILE, u.joints)
        return cls(np.ascontiguousarray(tiles.transpose(1, 3, 0, 2)), numbers)

    def torque(self, x: States) -> Floats:
        out = np.empty(x.q.shape)
        states, centres, parts = prepared(x), self.centres, len(self.centres)

        def write(rows: slice) -> None:
            part, to = states[rows], out[rows]
            loop("centres_apply")(*self.numbers, part, len(part), centres, parts, to)

        threads.over_rows(write, len(x), len(x) * parts * TILE / PAIRS_A_BLOCK)
        return out


class _Scalar(_Universal, base.IndependentKernel):
    """The scalar Lagrangian kernels: the diagonal of (22), joint by joint."""

    def cross(self, x: States, u: States, joint: int) -> Floats:
        out = np.empty((len(x), len(u)))
        states = prepared(x), len(x), prepared(u), len(u)
        loop("universal_diagonal")(*self.numbers(x.joints, joint), *states, joint, out)
        return out

    def apply(self, x: States, u: States, a: Floats) -> Floats:
        out = np.empty(x.q.shape)
        states = prepared(x), len(x), prepared(u), len(u)
        coefficients = np.ascontiguousarray(a)
        for joint in range(x.joints):
            numbers = self.numbers(x.joints, joint)
            loop("universal_diagonal_apply")(*numbers, *states, joint, coefficients, out)
        return out

    def variance(self, x: States) -> Floats:
        out, every = np.empty((2, len(x), x.joints))
        for joint in range(x.joints):
            numbers = self.numbers(x.joints, joint)
            loop("universal_variance")(*numbers, prepared(x), len(x), every)
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
    meaning = "a separate Lagrangian for each joint, rbf in position and velocity"
    angles = False


class Srbfs(_Scalar):
    """Scalar Lagrangian kernels (35) of the rbf kernel on cosines and sines (39)."""

    name = "srbfs"
    meaning = "a separate Lagrangian for each joint, rbf in the cosines and sines"
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
