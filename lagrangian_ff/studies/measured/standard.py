"""The standard way: base parameters, rotors and friction by weighted least squares.

The torque of rigid bodies is linear in their parameters: τ = Y(q, qd, qdd) π. Columns of Y that no
motion of this arm distinguishes are left out (base parameters by QR, Gautier 1991). Each joint also
has a rotor, viscous and Coulomb friction and an offset. Rows are weighted by the standard deviation
of their joint's residual (Gautier and Poignet 2001). The regressor is Pinocchio's; nothing here is
shared with the models that are compared with it but the conditioned motion.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy

from lagrangian_ff.arrays import Floats, Ints
from lagrangian_ff.errors import ModelError
from lagrangian_ff.recording.motion import Motion

ROUNDS = 2
"""How often the weights follow from the residual."""
RANDOM_STATES, SPREAD = 300, (np.pi, 3.0, 10.0)
"""States that decide which columns are independent; rad, rad/s, rad/s² to both sides."""
DEPENDENT = 1e-7
"""Columns whose diagonal of R is below this share of the largest depend on the others."""
OWN = 4
"""Columns that each joint has to itself: rotor, viscous and Coulomb friction, offset."""
STANDSTILL = 0.02
"""rad/s, below which dry friction is less than all: that of the package's own Coulomb friction."""


@dataclass(frozen=True)
class StandardWay:
    """A rigid-body model identified in the standard way.

    Attributes:
        body: Pinocchio's model.  order: (N,) the place of each joint among its coordinates.
        base: indices of the independent columns.  parameters: of these.
    """

    body: Any
    order: Ints
    base: Ints
    parameters: Floats

    @classmethod
    def identified(
        cls, urdf: str, gravity: Sequence[float], motion: Motion, source: str
    ) -> "StandardWay":
        """Identify an arm from motion.

        Raises:
            ModelError: Pinocchio is not installed or cannot read the URDF, the URDF has not the
                joints of the motion, or the motion is too short for its parameters.
        """
        body, order = _body(urdf, gravity, motion.joints, source)
        base = _base_columns(body, order)
        design, joints = _design(body, order, motion.q, motion.qd, motion.qdd), len(order)
        design = design[:, base]
        target = motion.tau.ravel()
        if len(target) <= len(base):
            raise ModelError(
                f"{motion.source}: {len(target)} torques for {len(base)} parameters; record longer"
            )
        weight = np.ones(joints)
        for _ in range(ROUNDS + 1):
            rows = np.tile(weight, len(motion))
            solved = scipy.linalg.lstsq(rows[:, None] * design, rows * target)[0]
            left = (target - design @ solved).reshape(-1, joints)
            deviation = np.sqrt(np.mean(left**2, axis=0))
            weight = 1.0 / np.maximum(deviation, 1e-9 * deviation.max())
        return cls(body, order, base, solved)

    def predict(self, motion: Motion) -> Floats:
        """Return (M, N) N·m."""
        design = _design(self.body, self.order, motion.q, motion.qd, motion.qdd)
        return np.asarray((design[:, self.base] @ self.parameters).reshape(motion.tau.shape))


def _body(
    urdf: str, gravity: Sequence[float], joints: Sequence[str], source: str
) -> tuple[Any, Ints]:
    """Return Pinocchio's model of the joints, and the place of each among its coordinates."""
    try:
        import pinocchio
    except ImportError as error:
        raise ModelError(
            "the standard way needs Pinocchio, which is not installed; it is the extra 'urdf' of "
            "lagrangian_ff: pip install pin, or with ROS: apt install ros-jazzy-pinocchio"
        ) from error
    try:
        whole = pinocchio.buildModelFromXML(urdf)
    except ValueError as error:
        raise ModelError(f"{source}: Pinocchio cannot read the URDF: {error}") from error
    names = list(whole.names)[1:]
    absent = [joint for joint in joints if joint not in names]
    if absent:
        raise ModelError(f"{source}: no joint {', '.join(absent)}; it has {', '.join(names)}")
    still = [k + 1 for k, name in enumerate(names) if name not in joints]
    body = pinocchio.buildReducedModel(whole, still, pinocchio.neutral(whole)) if still else whole
    body.gravity.linear = np.array(gravity)
    held = list(body.names)[1:]
    return body, np.array([held.index(joint) for joint in joints])


def _design(body: Any, order: Ints, q: Floats, qd: Floats, qdd: Floats) -> Floats:
    """Return (M N, P) columns of the bodies, rotors, viscous and Coulomb friction and offsets."""
    import pinocchio

    data, (samples, joints) = body.createData(), q.shape
    back = np.argsort(order)
    position, velocity, acceleration = (values[:, back] for values in (q, qd, qdd))
    out = np.zeros((samples, joints, (10 + OWN) * joints))
    for row in range(samples):
        at = _configuration(body, position[row])
        rows = pinocchio.computeJointTorqueRegressor(
            body, data, at, velocity[row], acceleration[row]
        )
        out[row, :, : 10 * joints] = rows[order]
    for joint in range(joints):
        first = 10 * joints + OWN * joint
        friction = np.tanh(qd[:, joint] / STANDSTILL)
        columns = qdd[:, joint], qd[:, joint], friction, np.ones(samples)
        out[:, joint, first : first + OWN] = np.stack(columns, axis=1)
    return out.reshape(samples * joints, -1)


def _configuration(body: Any, position: Floats) -> Floats:
    """Return Pinocchio's coordinates: joints without limits have a cosine and a sine."""
    if body.nq == body.nv:
        return position
    out = np.empty(body.nq)
    for joint in list(body.joints)[1:]:
        value = position[joint.idx_v]
        if joint.nq == 2:
            out[joint.idx_q : joint.idx_q + 2] = np.cos(value), np.sin(value)
        else:
            out[joint.idx_q] = value
    return out


def _base_columns(body: Any, order: Ints) -> Ints:
    """Return the indices of columns that are independent, for motion of any kind."""
    random = np.random.default_rng(0)
    states = (random.uniform(-s, s, (RANDOM_STATES, len(order))) for s in SPREAD)
    design = _design(body, order, *states)
    scale = np.linalg.norm(design, axis=0)
    moved = np.flatnonzero(scale > 0.0)
    _, upper, picked = scipy.linalg.qr(
        design[:, moved] / scale[moved], mode="economic", pivoting=True
    )
    size = np.abs(np.diag(upper))
    return np.asarray(np.sort(moved[picked[size > DEPENDENT * size[0]]]))
