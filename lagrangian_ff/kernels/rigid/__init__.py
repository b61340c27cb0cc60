"""Robots whose rigid bodies a URDF describes."""

from lagrangian_ff.kernels.rigid.robot import Robot, read_urdf, robot_of
from lagrangian_ff.kernels.rigid.tree import Tree

__all__ = ["Robot", "Tree", "read_urdf", "robot_of"]
