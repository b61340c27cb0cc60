"""The links of the arm in one PyBullet world."""

import os
import tempfile
from collections.abc import Mapping, Sequence
from types import TracebackType

import numpy as np
import pybullet
from numpy.typing import NDArray

from lagrangian_ff.arm.description import JOINTS, URDF, Load, on_links, robot_description

Floats = NDArray[np.float64]

GRAVITY = 9.81  # m/s², down along z of the base


class Body:
    """Rigid links and frictionless joints, as PyBullet computes them.

    A world of its own without a window (p.DIRECT); close it, or use it in a `with` block.

    Args:
        loads: kg (or Load) by joint or link.
        dt: s, the step of the integration.

    Raises:
        ArmError: a load on no link of the arm.
    """

    def __init__(
        self, loads: Mapping[str, float | Load] | None = None, *, dt: float = 1e-3
    ) -> None:
        on_links(loads)
        self.client = pybullet.connect(pybullet.DIRECT)
        self._args = {"physicsClientId": self.client}
        pybullet.setGravity(0.0, 0.0, -GRAVITY, **self._args)
        pybullet.setTimeStep(dt, **self._args)
        self.id = self._load(loads)
        count = pybullet.getNumJoints(self.id, **self._args)
        names = {
            pybullet.getJointInfo(self.id, k, **self._args)[1].decode(): k for k in range(count)
        }
        self.index = [names[joint] for joint in JOINTS]
        # Bullet damps velocities and holds joints with motors of its own unless told not to.
        for link in range(-1, count):
            pybullet.changeDynamics(
                self.id,
                link,
                linearDamping=0.0,
                angularDamping=0.0,
                jointDamping=0.0,
                **self._args,
            )
        pybullet.setJointMotorControlArray(
            self.id,
            self.index,
            pybullet.VELOCITY_CONTROL,
            forces=[0.0] * len(self.index),
            **self._args,
        )
        self._rest = [0.0] * len(self.index)

    def _load(self, loads: Mapping[str, float | Load] | None) -> int:
        flags = pybullet.URDF_USE_INERTIA_FROM_FILE
        if not loads:
            return int(pybullet.loadURDF(str(URDF), useFixedBase=True, flags=flags, **self._args))
        handle, path = tempfile.mkstemp(suffix=".urdf")
        try:
            with os.fdopen(handle, "w", encoding="utf-8") as file:
                file.write(robot_description(loads))
            return int(pybullet.loadURDF(path, useFixedBase=True, flags=flags, **self._args))
        finally:
            os.unlink(path)

    def set_state(self, q: Floats, qd: Floats) -> None:
        """Put the joints at q (6,) rad, moving at qd (6,) rad/s."""
        pybullet.resetJointStatesMultiDof(
            self.id,
            self.index,
            [[x] for x in q.tolist()],
            [[x] for x in qd.tolist()],
            **self._args,
        )

    def state(self) -> tuple[Floats, Floats]:
        """Positions and velocities of the joints, (6,) rad and (6,) rad/s."""
        states = pybullet.getJointStates(self.id, self.index, **self._args)
        return np.array([s[0] for s in states]), np.array([s[1] for s in states])

    def advance(self, torque: Floats) -> None:
        """Let the joint torques (6,) N·m act for one step."""
        pybullet.setJointMotorControlArray(
            self.id,
            self.index,
            pybullet.TORQUE_CONTROL,
            forces=torque.tolist(),
            **self._args,
        )
        pybullet.stepSimulation(**self._args)

    def dynamics(
        self, q: list[float], qd: list[float]
    ) -> tuple[Sequence[Sequence[float]], Sequence[float]]:
        """The rows of the mass matrix in kg·m² and the bias in N·m, of q rad and qd rad/s.

        The bias is the gravity, Coriolis and centrifugal torque.
        """
        body, client = self.id, self.client
        mass = pybullet.calculateMassMatrix(body, q, physicsClientId=client)
        bias = pybullet.calculateInverseDynamics(body, q, qd, self._rest, physicsClientId=client)
        return mass, bias

    def mass_matrix(self, q: Floats) -> Floats:
        """(6, 6) kg·m² of the links at q (6,)."""
        return np.array(self.dynamics(q.tolist(), self._rest)[0])

    def bias(self, q: Floats, qd: Floats) -> Floats:
        """Gravity, Coriolis and centrifugal torque (6,) N·m at q and qd, (6,) each."""
        return np.array(self.dynamics(q.tolist(), qd.tolist())[1])

    def inverse_dynamics(self, q: Floats, qd: Floats, qdd: Floats) -> Floats:
        """The torques (M, 6) N·m of the links alone in states (M, 6)."""
        torque = np.empty(q.shape)
        call, body, client = pybullet.calculateInverseDynamics, self.id, self.client
        states = zip(q.tolist(), qd.tolist(), qdd.tolist(), strict=True)
        for row, (position, velocity, acceleration) in enumerate(states):
            torque[row] = call(body, position, velocity, acceleration, physicsClientId=client)
        return torque

    def tool_jacobian(self, q: Floats) -> Floats:
        """(3, 6) m: how the last link's origin moves with the joints, along the base's axes."""
        linear = pybullet.calculateJacobian(
            self.id, self.index[-1], [0.0] * 3, q.tolist(), self._rest, self._rest, **self._args
        )[0]
        return np.array(linear)

    def potential_energy(self) -> float:
        """J of the links in gravity, from the floor up, at the present state."""
        energy = 0.0
        for link in range(pybullet.getNumJoints(self.id, **self._args)):
            mass = pybullet.getDynamicsInfo(self.id, link, **self._args)[0]
            centre = pybullet.getLinkState(self.id, link, computeForwardKinematics=1, **self._args)[
                0
            ]
            energy += mass * GRAVITY * centre[2]
        return energy

    def close(self) -> None:
        """End the world; closing twice is harmless."""
        if self.client >= 0:
            pybullet.disconnect(**self._args)
            self.client = -1

    def __enter__(self) -> "Body":
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()

    def __del__(self) -> None:
        if getattr(self, "client", -1) >= 0 and pybullet is not None:
            self.close()
