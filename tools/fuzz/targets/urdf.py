"""Robot descriptions: the simulated arm's, and one with every kind of joint."""

import shutil
from pathlib import Path

import numpy as np

from fuzz.target import Target
from lagrangian_ff.arm.description import URDF as ARM
from lagrangian_ff.kernels import States
from lagrangian_ff.kernels.rigid import read_urdf

KINDS = """<robot name="kinds">
  <link name="base"/>
  <link name="a"><inertial><mass value="1"/><origin xyz="0 0 0.1"/>
    <inertia ixx="0.1" ixy="0" ixz="0" iyy="0.1" iyz="0" izz="0.1"/></inertial></link>
  <link name="b"><inertial><mass value="2"/>
    <inertia ixx="0.1" ixy="0" ixz="0" iyy="0.1" iyz="0" izz="0.1"/></inertial></link>
  <link name="c"/><link name="d"/>
  <joint name="turn" type="revolute"><parent link="base"/><child link="a"/><axis xyz="0 0 1"/>
    <limit lower="-1" upper="1" effort="10" velocity="1"/></joint>
  <joint name="slide" type="prismatic"><parent link="a"/><child link="b"/><axis xyz="1 0 0"/>
    <limit lower="-1" upper="1" effort="10" velocity="1"/></joint>
  <joint name="wheel" type="continuous"><parent link="b"/><child link="c"/>
    <mimic joint="turn" multiplier="2" offset="0.1"/></joint>
  <joint name="flange" type="fixed"><parent link="c"/><child link="d"/></joint>
</robot>
"""
TOKENS = (
    b"<joint",
    b"<link",
    b"<mimic joint=",
    b'type="floating"',
    b'type="fixed"',
    b"<inertial>",
    b"<axis",
    b'<!DOCTYPE r [<!ENTITY a "aaaaaaaaaa">]>',
    b"<robot>",
    b"</robot>",
    b'xyz="0 0 0"',
    b'value="nan"',
    b'name=""',
    b"<parent",
    b'<child link="base"/>',
)


def _seeds(folder: Path) -> None:
    shutil.copy(ARM, folder / "arm.urdf")
    (folder / "kinds.urdf").write_text(KINDS)


def _read(path: Path) -> None:
    """Read a robot and compute its torques on its first joints."""
    robot = read_urdf(path)
    robot = robot.of_joints(robot.movable[:2], path.name)
    still = np.zeros((2, len(robot.joints)))
    robot.tree.torque(States.of(still, still, still))


URDF = Target("urdf", _seeds, _read, TOKENS)
