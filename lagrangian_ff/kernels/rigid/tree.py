"""Rigid bodies on joints: their torques, which are linear in the bodies' inertial parameters.

Body b has the ten parameters m, m c (3), and Ixx, Ixy, Iyy, Ixz, Iyz, Izz about the origin of its
frame. With ω, ω̇ and a the angular velocity, angular acceleration and acceleration of that frame,
less gravity, the force and the moment that move the body are (Newton-Euler; Atkeson, An and
Hollerbach 1986)

    f = m a + (ω̇× + ω× ω×) m c,        n = m c × a + I ω̇ + ω × I ω.
"""

from dataclasses import dataclass

import numpy as np
import scipy
from numpy.typing import NDArray

from lagrangian_ff.kernels.states import States, contiguous
from lagrangian_ff.loops import loop

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

GRAVITY = (0.0, 0.0, -9.81)  # m/s², in the frame of the base


@dataclass(frozen=True)
class Tree:
    """B bodies, each on one joint, that hang on each other as a tree.

    Attributes:
        parent: (B,) the body that carries each, before it in order; −1 for the base.
        rotation: (B, 3, 3) of each joint's frame in that of the parent, at zero.
        offset: (B, 3) m, its origin there.
        axis: (B, 3) unit vector in the joint's own frame.
        sliding: (B,) 1 where the joint is prismatic, 0 where it turns.
        driver: (B,) the coordinate that moves the joint; −1 where it stands still.
        ratio: (B,) joint position per unit of the coordinate.  shift: (B,) and at zero of it.
        inertial: (B, 10) the parameters as the CAD has them, about the origin of the joint's frame.
        gravity: (3,) m/s².
    """

    parent: Ints
    rotation: Floats
    offset: Floats
    axis: Floats
    sliding: Floats
    driver: Ints
    ratio: Floats
    shift: Floats
    inertial: Floats
    gravity: Floats

    @property
    def bodies(self) -> int:
        """B."""
        return len(self.parent)

    def torque(self, x: States) -> Floats:
        """(M, N) N·m, or N of prismatic joints, of the bodies as the CAD has them."""
        return np.asarray(self.regressor(x) @ self.inertial.ravel())

    def regressor(self, x: States) -> Floats:
        """(M, N, 10 B) torque of each joint per unit of each body's parameters."""
        out = np.zeros((len(x), x.joints, self.bodies, 10))
        tree = (
            self.parent, self.rotation, self.offset, self.axis, self.sliding, self.driver,
            self.ratio, self.shift, np.asarray(self.gravity, dtype=np.float64),
        )  # fmt: skip
        sizes = x.joints, self.bodies, len(x)
        loop("rigid_regressor")(*sizes, *contiguous(x), *map(np.ascontiguousarray, tree), out)
        return out.reshape(len(x), x.joints, -1)

    def momentum(self, x: States) -> Floats:
        """(M, N, 10 B) momentum ∂L/∂qd of each joint per unit of each body's parameters."""
        rest = x.at_rest()
        return self.regressor(States(x.q, rest.qd, x.qd)) - self.regressor(rest)

    def potential(self, q: Floats) -> Floats:
        """(M, 10 B) J of potential energy per unit of each body's parameters, for q (M, N).

        It is zero where a body's mass is in the origin of the base.
        """
        out = np.zeros((len(q), self.bodies, 10))
        turns: list[Floats] = []
        places: list[Floats] = []
        for body, (parent, driver) in enumerate(zip(self.parent, self.driver, strict=True)):
            position = np.full(len(q), self.shift[body])
            if driver >= 0:
                position += self.ratio[body] * q[:, driver]
            slides = bool(self.sliding[body] > 0.0)
            moved = self.rotation[body] @ self.axis[body] * (position * slides)[:, None]
            own = scipy.spatial.transform.Rotation.from_rotvec(
                self.axis[body] * (position * (not slides))[:, None]
            )
            turn, place = self.rotation[body] @ own.as_matrix(), self.offset[body] + moved
            if parent >= 0:
                place = places[parent] + np.einsum("mij,mj->mi", turns[parent], place)
                turn = turns[parent] @ turn
            turns.append(turn)
            places.append(place)
            out[:, body, 0] = -place @ self.gravity
            out[:, body, 1:4] = -np.einsum("i,mij->mj", self.gravity, turn)
        return out.reshape(len(q), -1)
