"""The links of the arm in a PyBullet world, and their distance from each other and the floor."""

import os
import tempfile
from collections.abc import Sequence
from contextlib import AbstractContextManager

import numpy as np

from lagrangian_ff.arm.bullet import pybullet
from lagrangian_ff.arm.description import JOINTS, LINKS, URDF, Loads, on_links, robot_description
from lagrangian_ff.arm.trajectory import Trajectory
from lagrangian_ff.arrays import Floats
from lagrangian_ff.errors import ArmError

GRAVITY = 9.81  # m/s², down along z of the base
CHECK_EVERY = 0.05  # s between poses of a trajectory that are checked


class Body(AbstractContextManager["Body"]):
    """Rigid links and frictionless joints, as PyBullet computes them.

    In a separate world without a window (p.DIRECT) that is integrated in steps of `dt`, s; close
    it, or use it in a `with` block. `masses` are the mass and inertia of each link relative to
    those described, (6,).

    Raises:
        ArmError: a load on no link of the arm.
    """

    def __init__(
        self, loads: Loads = None, *, dt: float = 1e-3, masses: Sequence[float] = ()
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
        # By default Bullet damps velocities and holds joints with motors.
        for link in range(-1, count):
            pybullet.changeDynamics(
                self.id, link, linearDamping=0.0, angularDamping=0.0, jointDamping=0.0, **self._args
            )
        for link, factor in zip(self.index, masses, strict=False):
            self._scale(link, factor)
        self._rest = [0.0] * len(self.index)
        pybullet.setJointMotorControlArray(
            self.id, self.index, pybullet.VELOCITY_CONTROL, forces=self._rest, **self._args
        )

    def _load(self, loads: Loads) -> int:
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

    def _scale(self, link: int, factor: float) -> None:
        if factor != 1.0:
            mass, _, inertia, *_ = pybullet.getDynamicsInfo(self.id, link, **self._args)
            scaled = {
                "mass": factor * mass,
                "localInertiaDiagonal": [factor * moment for moment in inertia],
            }
            pybullet.changeDynamics(self.id, link, **scaled, **self._args)

    def set_state(self, q: Floats, qd: Floats) -> None:
        """Put the joints at q (6,) rad, moving at qd (6,) rad/s."""
        pybullet.resetJointStatesMultiDof(
            self.id, self.index, [[x] for x in q.tolist()], [[x] for x in qd.tolist()], **self._args
        )

    def state(self) -> tuple[Floats, Floats]:
        """Return positions and velocities of the joints, (6,) rad and (6,) rad/s."""
        states = pybullet.getJointStates(self.id, self.index, **self._args)
        return np.array([s[0] for s in states]), np.array([s[1] for s in states])

    def advance(self, torque: Floats) -> None:
        """Let the joint torques (6,) N·m act for one step."""
        pybullet.setJointMotorControlArray(
            self.id, self.index, pybullet.TORQUE_CONTROL, forces=torque.tolist(), **self._args
        )
        pybullet.stepSimulation(**self._args)

    def dynamics(
        self, q: list[float], qd: list[float]
    ) -> tuple[Sequence[Sequence[float]], Sequence[float]]:
        """Return the rows of the mass matrix, kg·m², and the bias, N·m, at q rad and qd rad/s.

        The bias is the gravity, Coriolis and centrifugal torque.
        """
        body, client = self.id, self.client
        mass = pybullet.calculateMassMatrix(body, q, physicsClientId=client)
        bias = pybullet.calculateInverseDynamics(body, q, qd, self._rest, physicsClientId=client)
        return mass, bias

    def inverse_dynamics(self, q: Floats, qd: Floats, qdd: Floats) -> Floats:
        """Return the torques (M, 6) N·m of the links alone in states (M, 6)."""
        torque = np.empty(q.shape)
        call, body, client = pybullet.calculateInverseDynamics, self.id, self.client
        states = zip(q.tolist(), qd.tolist(), qdd.tolist(), strict=True)
        for row, (position, velocity, acceleration) in enumerate(states):
            torque[row] = call(body, position, velocity, acceleration, physicsClientId=client)
        return torque

    def tool_jacobian(self, q: Floats) -> Floats:
        """Return (3, 6) m/rad: the Jacobian of the last link's origin, along the base's axes."""
        linear = pybullet.calculateJacobian(
            self.id, self.index[-1], [0.0] * 3, q.tolist(), self._rest, self._rest, **self._args
        )[0]
        return np.array(linear)

    def close(self) -> None:
        """End the world; closing twice is harmless."""
        if self.client >= 0:
            pybullet.disconnect(**self._args)
            self.client = -1

    def __exit__(self, *_: object) -> None:
        self.close()

    def __del__(self) -> None:
        if getattr(self, "client", -1) >= 0 and pybullet is not None:
            self.close()


class Surroundings(AbstractContextManager["Surroundings"]):
    """The arm over a floor, in a separate world.

    Links that share a joint touch by design and are not compared; the loads on a link count as
    part of it. What is nearer than the margin, m, is a contact.
    """

    def __init__(self, loads: Loads = None, *, margin: float = 0.0) -> None:
        self._margin = margin
        self._body = Body(loads)
        self._args = {"physicsClientId": self._body.client}
        plane = pybullet.createCollisionShape(pybullet.GEOM_PLANE, **self._args)
        self._floor = pybullet.createMultiBody(0, plane, **self._args)
        self._names = {-1: "base_link"}
        for k in range(pybullet.getNumJoints(self._body.id, **self._args)):
            self._names[k] = pybullet.getJointInfo(self._body.id, k, **self._args)[12].decode()
        self._pairs, self._low = self._candidates()

    def _candidates(self) -> tuple[list[tuple[int, int]], list[int]]:
        order = {"base_link": 0} | {name: n for n, name in enumerate(LINKS, start=1)}
        links = [(k, order[name.removeprefix("load_on_")]) for k, name in self._names.items()]
        pairs = [
            (a, b) for a, rank_a in links for b, rank_b in links if rank_b - rank_a > 1 and a != b
        ]
        # The base and the first link cannot reach the floor.
        return pairs, [k for k, rank in links if rank > 1]

    def first_contact(self, q: Floats) -> str | None:
        """Return what is nearer than the margin at q (6,) rad, in words; None if nothing is."""
        body, floor, args = self._body.id, self._floor, self._args
        self._body.set_state(q, np.zeros_like(q))
        for a, b in self._pairs:
            if pybullet.getClosestPoints(body, body, self._margin, a, b, **args):
                return f"{self._names[a]} and {self._names[b]}"
        for link in self._low:
            if pybullet.getClosestPoints(body, floor, self._margin, link, **args):
                return f"{self._names[link]} and the floor"
        return None

    def __exit__(self, *_: object) -> None:
        self._body.close()


def check_clearance(trajectory: Trajectory, loads: Loads = None) -> None:
    """Check every 50 ms of a trajectory that the arm touches neither itself nor the floor.

    Raises:
        ArmError: it does; names what touches, and when.
    """
    count = int(np.ceil(trajectory.duration / CHECK_EVERY)) + 1
    times = np.linspace(trajectory.time[0], trajectory.time[-1], count)
    with Surroundings(loads) as surroundings:
        for time, q in zip(times, trajectory.select(JOINTS).sample(times)[0], strict=True):
            contact = surroundings.first_contact(q)
            if contact is not None:
                raise ArmError(f"trajectory: {contact} touch at {time:.2f} s")
