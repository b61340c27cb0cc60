"""The main job over ROS 2: record the simulated arm, identify it, and track better.

`run` starts the nodes as separate processes, drives them through a `Conductor`, and leaves figures,
numbers and one page that shows them. Only `run` imports rclpy.
"""

from lagrangian_ff.demo.options import QUICK, Options
from lagrangian_ff.demo.run import run

__all__ = ["QUICK", "Options", "run"]
