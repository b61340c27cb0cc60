"""The kinematics of a measured arm: a URDF, or a Denavit-Hartenberg table written as one."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from xml.etree import ElementTree

import numpy as np

from lagrangian_ff.arrays import Floats
from lagrangian_ff.errors import ModelError
from lagrangian_ff.kernels.rigid import Robot, robot_of

STANDARD, MODIFIED = "standard", "modified"
DENSITY, THICKNESS = 2000.0, 0.1
"""kg/m³ and m, of a link whose mass is not known: a square bar as long as the link."""
LIMIT = {"lower": "-1000", "upper": "1000", "effort": "1000", "velocity": "1000"}
"""A URDF must name limits; nothing here uses them."""


@dataclass(frozen=True)
class Row:
    """A row of a Denavit-Hartenberg table.

    Attributes:
        a, d: m.  alpha, theta: rad; theta is what is added to the joint's position.
        mass: kg, of the link behind the joint; None where it is not known.
        centre: (3,) m, of that mass in the frame of the row; None takes the middle of the link.
    """

    a: float
    d: float
    alpha: float
    theta: float = 0.0
    mass: float | None = None
    centre: tuple[float, ...] | None = None


@dataclass(frozen=True)
class Kinematics:
    """What is known of the bodies.

    Attributes:
        source: where that stands.
        urdf: the file; None if there is a table instead.
        convention: of the table, `standard` or `modified` (Craig).
        rows: of the table, from the base to the tool.
        gravity: (3,) m/s², in the frame of the base.
    """

    source: str
    urdf: Path | None = None
    convention: str = STANDARD
    rows: tuple[Row, ...] = ()
    gravity: tuple[float, ...] = (0.0, 0.0, -9.81)

    def text(self, joints: Sequence[str]) -> str:
        """Return the URDF; that of a table has links whose masses are guessed where not known.

        Raises:
            ModelError: the file cannot be read.
        """
        if self.urdf is None:
            return _urdf(self, joints)
        try:
            return self.urdf.read_text(encoding="utf-8")
        except (OSError, UnicodeDecodeError) as error:
            raise ModelError(f"cannot read the URDF {self.urdf}: {error}") from error

    def robot(self, joints: Sequence[str]) -> Robot:
        """Return the robot for `identify`; errors are those of `robot_of`."""
        robot = robot_of(self.text(joints), str(self.urdf or self.source))
        return replace(robot, tree=replace(robot.tree, gravity=np.array(self.gravity)))


def _urdf(known: Kinematics, joints: Sequence[str]) -> str:
    """Return the URDF of a table: every joint turns about z of its own frame."""
    robot = ElementTree.Element("robot", name="arm")
    ElementTree.SubElement(robot, "link", name="base")
    before = np.eye(4)  # from the link before to the frame that the joint turns
    parent = "base"
    for joint, row in zip(joints, known.rows, strict=True):
        about_z = _transform(0.0, row.d, 0.0, row.theta)
        along_x = _transform(row.a, 0.0, row.alpha, 0.0)
        placed = before @ (along_x @ about_z if known.convention == MODIFIED else about_z)
        before = np.eye(4) if known.convention == MODIFIED else along_x
        _add(robot, joint, parent, placed, _centred(row, before), row)
        parent = f"{joint}_link"
    return ElementTree.tostring(robot, encoding="unicode")


def _centred(row: Row, behind: Floats) -> Floats:
    """Return (3,) m the centre of a link's mass in the frame that its joint turns.

    Args:
        row: of the link; its centre is in the frame of the row.
        behind: from that frame to the one that the joint turns.
    """
    if row.centre is None:
        return np.asarray(0.5 * behind[:3, 3])
    return np.asarray(behind[:3, :3] @ np.array(row.centre) + behind[:3, 3])


def _add(
    robot: ElementTree.Element, name: str, parent: str, placed: Floats, centre: Floats, row: Row
) -> None:
    """Add a joint and the link behind it."""
    long = float(np.hypot(row.a, row.d)) + THICKNESS
    mass = DENSITY * THICKNESS**2 * long if row.mass is None else row.mass
    about = mass * (long**2 + THICKNESS**2) / 12.0
    link = ElementTree.SubElement(robot, "link", name=f"{name}_link")
    inertial = ElementTree.SubElement(link, "inertial")
    ElementTree.SubElement(inertial, "origin", xyz=_words(centre), rpy="0 0 0")
    ElementTree.SubElement(inertial, "mass", value=repr(mass))
    values = {"ixx": about, "iyy": about, "izz": about, "ixy": 0.0, "ixz": 0.0, "iyz": 0.0}
    ElementTree.SubElement(inertial, "inertia", {key: repr(v) for key, v in values.items()})
    joint = ElementTree.SubElement(robot, "joint", name=name, type="revolute")
    origin = {"xyz": _words(placed[:3, 3]), "rpy": _words(_angles(placed))}
    ElementTree.SubElement(joint, "origin", origin)
    ElementTree.SubElement(joint, "parent", link=parent)
    ElementTree.SubElement(joint, "child", link=f"{name}_link")
    ElementTree.SubElement(joint, "axis", xyz="0 0 1")
    ElementTree.SubElement(joint, "limit", LIMIT)


def _transform(a: float, d: float, alpha: float, theta: float) -> Floats:
    """Return (4, 4) Rot_x(alpha) Trans_x(a) Trans_z(d) Rot_z(theta)."""
    ca, sa, ct, st = np.cos(alpha), np.sin(alpha), np.cos(theta), np.sin(theta)
    about_x = np.array([[1, 0, 0, a], [0, ca, -sa, 0], [0, sa, ca, 0], [0, 0, 0, 1]])
    about_z = np.array([[ct, -st, 0, 0], [st, ct, 0, 0], [0, 0, 1, d], [0, 0, 0, 1]])
    return np.asarray(about_x @ about_z)


def _angles(placed: Floats) -> Floats:
    """Return (3,) rad roll, pitch and yaw."""
    turn = placed[:3, :3]
    pitch = np.arctan2(-turn[2, 0], np.hypot(turn[0, 0], turn[1, 0]))
    if np.hypot(turn[0, 0], turn[1, 0]) < 1e-9:  # only the sum of roll and yaw shows
        return np.array([np.arctan2(-turn[1, 2], turn[1, 1]), pitch, 0.0])
    roll, yaw = np.arctan2(turn[2, 1], turn[2, 2]), np.arctan2(turn[1, 0], turn[0, 0])
    return np.array([roll, pitch, yaw])


def _words(values: Floats) -> str:
    return " ".join(repr(float(value)) for value in values)
