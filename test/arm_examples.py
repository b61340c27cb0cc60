"""Moves of the simulated arm, and the mechanics of its links that tests compare with."""

from collections.abc import Sequence

import numpy as np
import pybullet
from numpy.typing import NDArray

from lagrangian_ff.arm import Gear, Plant, Trajectory, limits
from lagrangian_ff.arm.body import GRAVITY, Body

Floats = NDArray[np.float64]


def move_to(start: Sequence[float] | Floats, goal: Sequence[float] | Floats) -> Trajectory:
    """Return a quintic from rest to rest, poses (6,) rad, at 40 % of the velocity limits."""
    q = np.array([start, goal])
    # A rest-to-rest quintic peaks at 15/8 of its mean velocity.
    slowest = np.max(15.0 / 8.0 * np.abs(q[1] - q[0]) / (0.4 * limits().velocity))
    still = np.zeros_like(q)
    return Trajectory(np.array([0.0, max(1.0, float(slowest))]), q, still, still)


def mass_matrix(body: Body, q: Floats) -> Floats:
    """Return (6, 6) kg·m² of the links at q (6,)."""
    return np.array(body.dynamics(q.tolist(), [0.0] * 6)[0])


def bias(body: Body, q: Floats, qd: Floats) -> Floats:
    """Return gravity, Coriolis and centrifugal torque (6,) N·m at q and qd, (6,) each."""
    return np.array(body.dynamics(q.tolist(), qd.tolist())[1])


def potential_energy(body: Body) -> float:
    """Return the links' potential energy, J above the floor, at the present state."""
    energy, args = 0.0, {"physicsClientId": body.client}
    for link in range(pybullet.getNumJoints(body.id, **args)):
        mass = pybullet.getDynamicsInfo(body.id, link, **args)[0]
        state = pybullet.getLinkState(body.id, link, computeForwardKinematics=1, **args)
        energy += mass * GRAVITY * state[0][2]
    return energy


def energy(plant: Plant, gears: Sequence[Gear] = ()) -> float:
    """Return the energy, J, of the links, the rotors and the springs of the plant's gears."""
    mass, armature = mass_matrix(plant.body, plant.q), plant.parameters.reflected_inertia
    kinetic = 0.5 * (plant.qd @ mass @ plant.qd + armature @ plant.rotor_velocity**2)
    springs = 0.0
    for gear in gears:
        twist = (plant.encoder - plant.q)[gear.joint]
        half = 0.5 * gear.play
        springs += 0.5 * gear.stiffness * float(twist - np.clip(twist, -half, half)) ** 2
    return float(kinetic) + springs + potential_energy(plant.body)
