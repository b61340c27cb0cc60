"""A serial robot of rotary joints: what is known of it, and its torques."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lagrangian_ff.kernels import States
from lagrangian_ff.studies.robots.newton_euler import inverse_dynamics

Floats = NDArray[np.float64]

GRAVITY = 9.81


@dataclass(frozen=True)
class Robot:
    """N links in a row; frame n stands on joint n, turns with link n, and its z is the axis.

    Attributes:
        rotation: (N, 3, 3) from frame n to the frame before it, at q = 0; the first is the base,
            whose z points up.
        offset: (N, 3) m, the origin of frame n in the frame before it.
        mass: (N,) kg.  centre: (N, 3) m, of mass, in frame n.
        inertia: (N, 3, 3) kg·m², about the centre of mass.
        gear: (N,) turns of the motor for one of the joint.
        motor_inertia: (N,) kg·m², of the motor's rotor about its own axis.
        viscous: (N,) N·m·s/rad.  coulomb: (N,) N·m.
    """

    rotation: Floats
    offset: Floats
    mass: Floats
    centre: Floats
    inertia: Floats
    gear: Floats
    motor_inertia: Floats
    viscous: Floats
    coulomb: Floats

    @property
    def joints(self) -> int:
        """The number of joints N."""
        return len(self.mass)

    @property
    def rotor(self) -> Floats:
        """(N,) kg·m², what the motor's rotor weighs at the joint."""
        return self.gear**2 * self.motor_inertia

    def torque(self, x: States) -> Floats:
        """(M, N) N·m that move the links and the rotors, without friction."""
        links = inverse_dynamics(
            self.rotation, self.offset, self.mass, self.centre, self.inertia, x, GRAVITY
        )
        return links + self.rotor * x.qdd

    def friction(self, x: States) -> Floats:
        """(M, N) N·m against viscous and Coulomb friction, the latter a sharp sign."""
        return self.viscous * x.qd + self.coulomb * np.sign(x.qd)

    def mass_matrix(self, q: Floats) -> Floats:
        """(M, N, N) kg·m², column by column what an acceleration of one joint adds."""
        still = States.of(q, np.zeros_like(q), np.zeros_like(q))
        columns = [
            self.torque(States.of(q, still.qd, np.broadcast_to(one, q.shape))) - self.torque(still)
            for one in np.eye(self.joints)
        ]
        return np.stack(columns, axis=-1)
