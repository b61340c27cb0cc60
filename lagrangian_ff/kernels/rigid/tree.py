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

from lagrangian_ff.arrays import Floats, Ints
from lagrangian_ff.kernels.states import States, contiguous
from lagrangian_ff.loops import loop

GRAVITY = (0.0, 0.0, -9.81)  # m/s², in the frame of the base
LEAST_MASS, LEAST_SIZE = 0.01, 0.02
"""Least mass of a body, relative to the heaviest, and least size, m, of an unknown one."""


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
        """Return the number of bodies, B."""
        return len(self.parent)

    @property
    def scale(self) -> Floats:
        """Return (B, 10) by how much each parameter may differ if it is not known at all."""
        mass = self.inertial[:, 0]
        heaviest = float(mass.max(initial=0.0)) or 1.0
        mass = np.maximum(mass, LEAST_MASS * heaviest)
        spread = np.abs(self.inertial[:, [4, 6, 9]]).sum(axis=1)
        size = np.maximum(np.sqrt(spread / mass), LEAST_SIZE)
        return np.stack([mass, *[mass * size] * 3, *[mass * size**2] * 6], axis=1)

    def torque(self, x: States) -> Floats:
        """Return (M, N) the torque, N·m (N if prismatic), of the bodies as the CAD has them."""
        return np.asarray(self.regressor(x) @ self.inertial.ravel())

    def regressor(self, x: States) -> Floats:
        """Return (M, N, 10 B) the torque of each joint per unit of each body's parameters."""
        out = np.zeros((len(x), x.joints, self.bodies, 10))
        frames = self.parent, self.rotation, self.offset, self.axis, self.sliding
        moved = self.driver, self.ratio, self.shift, np.asarray(self.gravity, dtype=np.float64)
        sizes, tree = (x.joints, self.bodies, len(x)), map(np.ascontiguousarray, (*frames, *moved))
        loop("rigid_regressor")(*sizes, *contiguous(x), *tree, out)
        return out.reshape(len(x), x.joints, -1)

    def momentum(self, x: States) -> Floats:
        """Return (M, N, 10 B) the momentum ∂L/∂qd per unit of each body's parameters."""
        rest = x.at_rest()
        return self.regressor(States(x.q, rest.qd, x.qd)) - self.regressor(rest)

    def potential(self, q: Floats) -> Floats:
        """Return (M, 10 B) potential energy, J per unit of each body's parameters, for q (M, N).

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
