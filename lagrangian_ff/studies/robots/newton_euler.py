"""The recursive Newton-Euler algorithm, for many states at once (Luh, Walker and Paul, 1980)."""

import numpy as np
from numpy.typing import NDArray

from lagrangian_ff.kernels import States

Floats = NDArray[np.float64]

AXIS = np.array([0.0, 0.0, 1.0])


def inverse_dynamics(
    rotation: Floats,
    offset: Floats,
    mass: Floats,
    centre: Floats,
    inertia: Floats,
    x: States,
    gravity: float,
) -> Floats:
    """(M, N) N·m that move serial links.

    Args:
        rotation, offset, mass, centre, inertia: of the links, see `Robot`.
        x: (M, N) states.
        gravity: m/s², along −z of the base.
    """
    count, joints = x.q.shape
    turned = [rotation[n] @ _about_axis(x.q[:, n]) for n in range(joints)]
    # Outwards: angular velocity, its rate, and the acceleration of the origin, in frame n. A base
    # that accelerates upwards stands for gravity.
    spin, rate = np.zeros((count, 3)), np.zeros((count, 3))
    origin = np.tile(gravity * AXIS, (count, 1))
    forces, moments = [], []
    for n in range(joints):
        origin = _into(turned[n], origin + _carried(spin, rate, offset[n]))
        before = _into(turned[n], spin)
        spin = before + AXIS * x.qd[:, [n]]
        rate = _into(turned[n], rate) + np.cross(before, AXIS * x.qd[:, [n]]) + AXIS * x.qdd[:, [n]]
        force = mass[n] * (origin + _carried(spin, rate, centre[n]))
        momentum = spin @ inertia[n]
        forces.append(force)
        moments.append(rate @ inertia[n] + np.cross(spin, momentum) + np.cross(centre[n], force))
    # Inwards: what joint n hands on to the links beyond it.
    torque = np.empty((count, joints))
    force, moment = np.zeros((count, 3)), np.zeros((count, 3))
    for n in reversed(range(joints)):
        force, moment = force + forces[n], moment + moments[n]
        torque[:, n] = moment[:, 2]
        force, moment = _out_of(turned[n], force), _out_of(turned[n], moment)
        moment = moment + np.cross(offset[n], force)
    return torque


def _about_axis(q: Floats) -> Floats:
    """(M, 3, 3) rotations by q about z."""
    out = np.zeros((len(q), 3, 3))
    out[:, 0, 0] = out[:, 1, 1] = np.cos(q)
    out[:, 1, 0] = np.sin(q)
    out[:, 0, 1] = -out[:, 1, 0]
    out[:, 2, 2] = 1.0
    return out


def _carried(spin: Floats, rate: Floats, arm: Floats) -> Floats:
    """(M, 3) how a point at the end of an arm accelerates because its frame turns."""
    return np.asarray(np.cross(rate, arm) + np.cross(spin, np.cross(spin, arm)))


def _into(turned: Floats, vectors: Floats) -> Floats:
    """(M, 3) vectors of the frame before, in the turned frame."""
    return np.asarray(np.einsum("mji,mj->mi", turned, vectors))


def _out_of(turned: Floats, vectors: Floats) -> Floats:
    """(M, 3) vectors of the turned frame, in the frame before."""
    return np.asarray(np.einsum("mij,mj->mi", turned, vectors))
