"""Robots whose rigid bodies a URDF describes."""

from lagrangian_ff.kernels.rigid.robot import Robot
from lagrangian_ff.kernels.rigid.tree import Tree
from lagrangian_ff.kernels.rigid.urdf import read_urdf, robot_of

__all__ = ["Robot", "Tree", "read_urdf", "robot_of"]
