"""The simulated arm: links with the dynamics of PyBullet; drives, servo, sensors and motions.

Names are imported when first asked for, so that a trajectory can be read without PyBullet.
"""

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from lagrangian_ff.arm.arm import Arm as Arm
    from lagrangian_ff.arm.arm import JointSample as JointSample
    from lagrangian_ff.arm.collision import check_clearance as check_clearance
    from lagrangian_ff.arm.description import HOME as HOME
    from lagrangian_ff.arm.description import JOINTS as JOINTS
    from lagrangian_ff.arm.description import PAPER_LOADS as PAPER_LOADS
    from lagrangian_ff.arm.description import Load as Load
    from lagrangian_ff.arm.description import limits as limits
    from lagrangian_ff.arm.description import robot_description as robot_description
    from lagrangian_ff.arm.drawing import picture as picture
    from lagrangian_ff.arm.exciting import exciting_trajectory as exciting_trajectory
    from lagrangian_ff.arm.gear import Gear as Gear
    from lagrangian_ff.arm.joint_effect import JointEffect as JointEffect
    from lagrangian_ff.arm.joint_effect import JointMoment as JointMoment
    from lagrangian_ff.arm.parameters import ArmParameters as ArmParameters
    from lagrangian_ff.arm.plant import Attached as Attached
    from lagrangian_ff.arm.plant import Plant as Plant
    from lagrangian_ff.arm.plant import true_torque as true_torque
    from lagrangian_ff.arm.servo import SensorEffect as SensorEffect
    from lagrangian_ff.arm.simulation import Run as Run
    from lagrangian_ff.arm.simulation import simulate as simulate
    from lagrangian_ff.arm.trajectory import Trajectory as Trajectory
    from lagrangian_ff.arm.trajectory import check_limits as check_limits
    from lagrangian_ff.arm.trajectory import move_to as move_to
    from lagrangian_ff.arm.trajectory_csv import read_trajectory as read_trajectory
    from lagrangian_ff.arm.trajectory_csv import write_trajectory as write_trajectory

_ROOM = {
    "arm": ("Arm", "JointSample"),
    "collision": ("check_clearance",),
    "description": ("HOME", "JOINTS", "PAPER_LOADS", "Load", "limits", "robot_description"),
    "exciting": ("exciting_trajectory",),
    "gear": ("Gear",),
    "joint_effect": ("JointEffect", "JointMoment"),
    "parameters": ("ArmParameters",),
    "drawing": ("picture",),
    "plant": ("Attached", "Plant", "true_torque"),
    "servo": ("SensorEffect",),
    "simulation": ("Run", "simulate"),
    "trajectory": ("Trajectory", "check_limits", "move_to"),
    "trajectory_csv": ("read_trajectory", "write_trajectory"),
}
_FILE = {name: file for file, names in _ROOM.items() for name in names}
__all__ = sorted(_FILE)


def __getattr__(name: str) -> object:
    if name not in _FILE:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f"{__name__}.{_FILE[name]}"), name)
