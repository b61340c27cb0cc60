"""The rigid bodies, friction and rotors of a URDF's joints that come nearest to a model's torque.

The torque is linear in the bodies' inertial parameters π, and so is a body's pseudo-inertia J, a 4
× 4 matrix that is positive definite just if the mass is positive, and the inertia about the centre
of mass is positive definite and obeys the triangle inequality (Wensing, Kim and Slotine 2018, IEEE
Robotics and Automation Letters 3(1)). To the squared error of the torque is added, for each body,
the divergence of J from that of the description, J0,

    D = tr(J0⁻¹ J) − log det(J0⁻¹ J) − 4,

which is convex, does not depend on the frame, and infinite for a body that cannot exist (Lee,
Wensing and Park 2020, IEEE Transactions on Robotics 36(2)). Damping, friction and rotors stay
above 0 by a logarithm of them. Newton's method finds the one minimum.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import scipy

from lagrangian_ff.arrays import Floats
from lagrangian_ff.export.result import Loss, rms
from lagrangian_ff.identification import Model
from lagrangian_ff.identification.samples import evenly
from lagrangian_ff.kernels import States
from lagrangian_ff.kernels.rigid import Robot, Tree

DEVIATION = 0.3
"""How far a body is expected to be from the description's, relatively."""
MOST_SAMPLES = 2000
FLOOR = 1e-4
"""Least eigenvalue of a pseudo-inertia J0, in parts of its largest: thinner bodies do not exist."""
FRICTION = ("viscous", "coulomb")
"""The effects that damping and friction of a joint stand for."""
PLACES = ((0, 0), (0, 1), (1, 1), (0, 2), (1, 2), (2, 2))
"""Where Ixx, Ixy, Iyy, Ixz, Iyz, Izz stand in the inertia."""
STEPS, ENOUGH = 200, 1e-9
"""Newton's steps at most, and nats of decrease that end them."""


@dataclass(frozen=True)
class Fit:
    """What was found of B bodies and N joints.

    Attributes:
        inertial: (B, 10) as `Tree` has them.
        damping, friction, armature: (N,) N·m·s/rad, N·m and kg·m², none below 0.
        torque: (M, N) N·m of these on the model's data.
        losses: what they do not hold of the model.
    """

    inertial: Floats
    damping: Floats
    friction: Floats
    armature: Floats
    torque: Floats
    losses: tuple[Loss, ...]


def robot_for(model: Model, robot: Robot) -> Robot:
    """Return a robot with the model's joints as coordinates, weightless if the model is.

    Raises:
        ModelError: it lacks a joint of the model.
    """
    placed = robot.of_joints(model.joints, "the model")
    return placed.without_gravity() if model.data.effort == "without-gravity" else placed


def fit(
    model: Model,
    robot: Robot,
    *,
    armature: bool,
    free: tuple[int, ...] | None = None,
    deviation: float = DEVIATION,
) -> Fit:
    """Return the bodies, friction and rotors that come nearest to a model on its own data.

    Args:
        model: whose torque is fitted.  robot: as `robot_for` returns it.
        armature: whether rotors may be found; else they are none.
        free: the bodies that are fitted; the others stay as they are. None is all.
        deviation: how far these are expected to be from the description's, relatively.
    """
    data, tree = model.data, robot.tree
    x = States.of(data.q, data.qd, data.qdd)
    target = model.torque(model.inputs_of(data))
    bodies = tuple(range(tree.bodies)) if free is None else free
    speed = model.basis.sign_speed(x.joints)
    some = evenly(len(x), MOST_SAMPLES)
    weight = 1.0 / (rms(target - data.tau) + 1e-2 * rms(target) + 1e-9)
    rows, right = _rows(x.take(some), tree, bodies, speed, weight, armature=armature)
    fixed = tree.inertial.copy()
    fixed[list(bodies)] = 0.0
    left_over = target[some] - _bodies_torque(tree, fixed, x.take(some))
    start = np.array([_existing(tree, body) for body in bodies])
    found = _solved(rows, right(left_over), start, x.joints, deviation)
    inertial = fixed.copy()
    inertial[list(bodies)] = found.inertial
    torque = _bodies_torque(tree, inertial, x) + found.armature * x.qdd
    torque += found.damping * x.qd + found.friction * np.tanh(x.qd / speed)
    return Fit(
        inertial=inertial,
        damping=found.damping,
        friction=found.friction,
        armature=found.armature,
        torque=torque,
        losses=_losses(model, tree, inertial, found.armature),
    )


def _bodies_torque(tree: Tree, inertial: Floats, x: States) -> Floats:
    """Return (M, N) N·m of bodies, a chunk of the states at a time."""
    out = np.empty(x.q.shape)
    for first in range(0, len(x), MOST_SAMPLES):
        part = slice(first, first + MOST_SAMPLES)
        out[part] = tree.regressor(x.take(part)) @ inertial.ravel()
    return out


def _rows(
    x: States, tree: Tree, bodies: tuple[int, ...], speed: Floats, weight: Floats, *, armature: bool
) -> tuple[Floats, Callable[[Floats], Floats]]:
    """Return the columns of all unknowns, (M N, K), and what makes rows of a torque (M, N).

    The unknowns are π of the bodies, then of every joint damping, friction, armature if it is
    wanted, and offset.
    """
    by_body = tree.regressor(x).reshape(len(x), x.joints, tree.bodies, 10)[:, :, list(bodies)]
    unit = np.eye(x.joints)
    rotors = [x.qdd] if armature else []
    joint_columns = [x.qd, np.tanh(x.qd / speed), *rotors, np.ones_like(x.q)]
    columns = [
        by_body.reshape(len(x), x.joints, -1),
        *(c[:, :, None] * unit for c in joint_columns),
    ]
    rows = np.concatenate(columns, axis=2) * weight[:, None]
    return rows.reshape(len(x) * x.joints, -1), lambda torque: (torque * weight).ravel()


@dataclass(frozen=True)
class _Solved:
    inertial: Floats
    damping: Floats
    friction: Floats
    armature: Floats


def _solved(rows: Floats, right: Floats, start: Floats, joints: int, deviation: float) -> _Solved:
    """Return the minimum of squares and divergences, see above; start: (K, 10) of J0."""
    count, unknown = start.size, rows.shape[1]
    square, linear = rows.T @ rows, rows.T @ right
    first = np.linalg.inv(pseudo_inertia(start))
    pull = np.einsum("bij,nij->bn", first, UNITS).ravel() / deviation**2
    positive = np.arange(count, unknown - joints)
    values = np.concatenate(
        [start.ravel(), np.full(unknown - count - joints, 0.1), np.zeros(joints)]
    )

    def height(at: Floats) -> float:
        """Return what is minimised; infinite where a body cannot exist."""
        sign, log = np.linalg.slogdet(pseudo_inertia(at[:count].reshape(-1, 10)))
        least = np.linalg.eigvalsh(pseudo_inertia(at[:count].reshape(-1, 10)))[:, 0]
        if (sign <= 0.0).any() or (least <= 0.0).any() or (at[positive] <= 0.0).any():
            return np.inf
        barrier = pull @ at[:count] - log.sum() / deviation**2 - np.log(at[positive]).sum()
        return float(0.5 * at @ square @ at - linear @ at + barrier)

    for _ in range(STEPS):
        slope, bend = square @ values - linear, square.copy()
        slope[:count] += pull
        turned = np.linalg.solve(pseudo_inertia(values[:count].reshape(-1, 10))[:, None], UNITS)
        for body, one in enumerate(turned):
            part = slice(10 * body, 10 * body + 10)
            slope[part] -= np.einsum("nii->n", one) / deviation**2
            bend[part, part] += np.einsum("nij,mji->nm", one, one) / deviation**2
        slope[positive] -= 1.0 / values[positive]
        bend[positive, positive] += 1.0 / values[positive] ** 2
        factor = scipy.linalg.cho_factor(bend)
        step = -scipy.linalg.cho_solve(factor, slope)
        decrease = -float(slope @ step)
        if decrease < ENOUGH:
            break
        before, length = height(values), 1.0
        while height(values + length * step) > before - 1e-4 * length * decrease and length > 1e-12:
            length *= 0.5
        values = values + length * step
    damping, friction, *rotors, _ = values[count:].reshape(-1, joints)
    rotor = rotors[0] if rotors else np.zeros(joints)
    return _Solved(values[:count].reshape(-1, 10), damping, friction, rotor)


def pseudo_inertia(inertial: Floats) -> Floats:
    """Return (B, 4, 4) [[Σ, m c], [m cᵀ, m]], Σ = tr(I) / 2 − I, of parameters (B, 10)."""
    out = np.zeros((len(inertial), 4, 4))
    trace = inertial[:, 4] + inertial[:, 6] + inertial[:, 9]
    for n, (i, j) in enumerate(PLACES):
        out[:, i, j] = out[:, j, i] = (0.5 * trace if i == j else 0.0) - inertial[:, 4 + n]
    out[:, :3, 3] = out[:, 3, :3] = inertial[:, 1:4]
    out[:, 3, 3] = inertial[:, 0]
    return out


UNITS = pseudo_inertia(np.eye(10))
"""(10, 4, 4) of each parameter alone."""


def _from_pseudo(matrix: Floats) -> Floats:
    """Return (B, 10) the parameters of pseudo-inertias (B, 4, 4)."""
    trace = matrix[:, 0, 0] + matrix[:, 1, 1] + matrix[:, 2, 2]
    inertia = [(trace if i == j else 0.0) - matrix[:, i, j] for i, j in PLACES]
    return np.stack([matrix[:, 3, 3], *matrix[:, 3, :3].T, *inertia], axis=1)


def _existing(tree: Tree, body: int) -> Floats:
    """Return (10,) a body's parameters, or the nearest of a body that can exist."""
    matrix = pseudo_inertia(tree.inertial[[body]])[0]
    values, vectors = np.linalg.eigh(matrix)
    least = tree.scale[body]
    floor = FLOOR * max(float(values[-1]), float(least[0]), float(least[9]))
    if values[0] < floor:
        matrix = (vectors * np.maximum(values, floor)) @ vectors.T
    return np.asarray(_from_pseudo(matrix[None])[0])


def _losses(model: Model, tree: Tree, inertial: Floats, armature: Floats) -> tuple[Loss, ...]:
    """Return the effects that are no friction of these, and what no such bodies do."""
    data = model.data
    x = States.of(data.q, data.qd, data.qdd)
    parts = model.basis.torque(model.inputs_of(data), model.coefficients)
    rigid = model.lagrangian_torque(x) - _bodies_torque(tree, inertial, x) - armature * x.qdd
    effects = [Loss(name, rms(part)) for name, part in parts.items() if name not in FRICTION]
    return (*effects, Loss("inertia and gravity that these bodies do not have", rms(rigid)))
