"""Mechanisms of which something is known, for tests of any room; none of them needs Pinocchio."""

import numpy as np
from numpy.typing import NDArray

from lagrangian_ff.kernels.constrained import Linkage
from lagrangian_ff.kernels.rigid import Robot, Tree
from lagrangian_ff.kernels.rigid.tree import GRAVITY

Floats = NDArray[np.float64]

PENDULUM_URDF = """<robot name="pendulum">
  <link name="wall"/>
  <link name="upper">
    <inertial><origin xyz="0.25 0 0"/><mass value="{upper}"/>
      <inertia ixx="0" ixy="0" ixz="0" iyy="{upper_y}" iyz="0" izz="{upper_y}"/></inertial>
  </link>
  <link name="lower">
    <inertial><origin xyz="0.2 0 0"/><mass value="{lower}"/>
      <inertia ixx="0" ixy="0" ixz="0" iyy="{lower_y}" iyz="0" izz="{lower_y}"/></inertial>
  </link>
  <joint name="shoulder" type="revolute">
    <parent link="wall"/><child link="upper"/><axis xyz="0 -1 0"/>
    <limit lower="-3" upper="3" velocity="9" effort="99"/>
  </joint>
  <joint name="elbow" type="continuous">
    <parent link="upper"/><child link="lower"/><origin xyz="0.5 0 0"/><axis xyz="0 -2 0"/>
  </joint>
</robot>
"""


def pendulum_urdf(upper: float = 2.0, lower: float = 1.0) -> str:
    """The two rods of `pendulum`, of the given kg."""
    return PENDULUM_URDF.format(
        upper=upper, lower=lower, upper_y=upper * 0.25 / 12, lower_y=lower * 0.16 / 12
    )


def tree_of(parent: tuple[int, ...], sliding: tuple[int, ...], seed: int) -> Tree:
    """Bodies of random places, axes and possible inertias on joints of their own."""
    rng = np.random.default_rng(seed)
    count = len(parent)
    axis = rng.normal(size=(count, 3))
    inertial = np.empty((count, 10))
    for body in range(count):
        # Four points of mass: whatever their places, a body that can be.
        mass, place = rng.uniform(0.2, 1.0, 4), rng.normal(scale=0.2, size=(4, 3))
        moment = np.einsum("k,kij->ij", mass, [np.eye(3) * (p @ p) - np.outer(p, p) for p in place])
        lower = moment[[0, 1, 1, 2, 2, 2], [0, 0, 1, 0, 1, 2]]
        inertial[body] = np.concatenate([[mass.sum()], mass @ place, lower])
    return Tree(
        parent=np.array(parent),
        rotation=np.linalg.qr(rng.normal(size=(count, 3, 3)))[0],
        offset=rng.normal(scale=0.4, size=(count, 3)),
        axis=axis / np.linalg.norm(axis, axis=1, keepdims=True),
        sliding=np.array(sliding, dtype=np.float64),
        driver=np.arange(count),
        ratio=np.ones(count),
        shift=np.zeros(count),
        inertial=inertial,
        gravity=np.array(GRAVITY),
    )


def robot(joints: tuple[str, ...] = ("a", "b", "c")) -> Robot:
    """Two joints that turn and one that slides, one after the other."""
    return Robot("three", tree_of((-1, 0, 1), (0, 0, 1), 7), joints, {}, joints)


class Crossed(Linkage):
    """Four joints that follow three in a made-up way, its Jacobian in closed form."""

    name = "crossed"
    joints = ("a", "b", "c")

    def positions(self, q: Floats) -> Floats:
        a, b, c = q.T
        return np.stack([a, b + 0.3 * np.sin(a), c, np.cos(b) - c], axis=1)

    def jacobian(self, q: Floats) -> Floats:
        a, b, _ = q.T
        out = np.zeros((len(q), 4, 3))
        out[:, 0, 0] = out[:, 1, 1] = out[:, 2, 2] = 1.0
        out[:, 1, 0], out[:, 3, 1], out[:, 3, 2] = 0.3 * np.cos(a), -np.sin(b), -1.0
        return out
