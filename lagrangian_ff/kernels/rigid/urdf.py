"""Read a URDF with Pinocchio."""

from collections.abc import Callable
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np

from lagrangian_ff.arrays import Floats
from lagrangian_ff.errors import ModelError
from lagrangian_ff.kernels.rigid.robot import Robot
from lagrangian_ff.kernels.rigid.tree import GRAVITY, Tree

MOVABLE = ("revolute", "continuous", "prismatic")
FIXED = "fixed"


def read_urdf(path: "str | Path") -> Robot:
    """Return the robot that a URDF file describes.

    Raises:
        ModelError: there is no such file, it is no URDF, or has a joint of an unsupported type.
    """
    try:
        text = Path(path).read_text(encoding="utf-8")
    except FileNotFoundError as error:
        raise ModelError(f"no URDF file {path}") from error
    except UnicodeDecodeError as error:
        raise ModelError(f"{path} is no URDF: it is not text ({error.reason})") from error
    except OSError as error:
        raise ModelError(f"cannot read the URDF {path}: {error.strerror}") from error
    return robot_of(text, str(path))


def robot_of(text: str, source: str) -> Robot:
    """Return the robot of a URDF's text.

    Fixed joints join their bodies. The base stands in the world as the root link does.

    Args:
        text: the XML.
        source: its origin, for messages.

    Raises:
        ModelError: it is no URDF, has no movable joint or one of an unsupported type, or Pinocchio
            is not installed.
    """
    joints = _joints(text, source)
    axes = {name: _axis(joint, source) for name, joint in joints.items()}
    follows = _follows(joints, source)
    build = _pinocchio(source)
    try:
        model = build(text)
    except ValueError as error:
        raise ModelError(f"{source}: Pinocchio cannot read the URDF: {error}") from error
    bodies = range(1, model.njoints)
    placements = [model.jointPlacements[n] for n in bodies]
    movable = tuple(str(model.names[n]) for n in bodies)
    sliding = np.array([float(joints[name].get("type") == "prismatic") for name in movable])
    tree = Tree(
        parent=np.array([int(model.parents[n]) - 1 for n in bodies]),
        rotation=np.array([placement.rotation for placement in placements]),
        offset=np.array([placement.translation for placement in placements]),
        axis=np.array([axes[name] for name in movable]), sliding=sliding,
        driver=np.arange(len(movable)), ratio=np.ones(len(movable)), shift=np.zeros(len(movable)),
        inertial=np.array([model.inertias[n].toDynamicParameters() for n in bodies]),
        gravity=np.array(GRAVITY),
    )  # fmt: skip
    name = str(ElementTree.fromstring(text).get("name") or Path(source).stem)
    return Robot(name, tree, movable, follows, movable)


def _pinocchio(source: str) -> Callable[[str], Any]:
    try:
        from pinocchio import buildModelFromXML
    except ImportError as error:
        raise ModelError(
            f"{source}: reading a URDF needs Pinocchio, which is not installed; it is the "
            "extra 'urdf' of lagrangian_ff: pip install pin, or with ROS: apt install "
            "ros-jazzy-pinocchio"
        ) from error
    return buildModelFromXML


def _joints(text: str, source: str) -> dict[str, ElementTree.Element]:
    """Return the joints by name; all are of supported types."""
    try:
        root = ElementTree.fromstring(text)
    except ElementTree.ParseError as error:
        hint = "; expand a xacro file first: xacro FILE.xacro > FILE.urdf"
        raise ModelError(f"{source} is no URDF: it is not XML ({error}){hint}") from error
    if root.tag != "robot":
        raise ModelError(f"{source} is no URDF: its root is <{root.tag}>, expected <robot>")
    joints = {str(joint.get("name")): joint for joint in root.findall("joint")}
    for name, joint in joints.items():
        kind = joint.get("type")
        if kind not in (*MOVABLE, FIXED):
            raise ModelError(
                f"{source}: joint {name} is of the type {kind}, expected one of "
                f"{', '.join([*MOVABLE, FIXED])}"
            )
    if not any(joint.get("type") in MOVABLE for joint in joints.values()):
        raise ModelError(f"{source}: the URDF has no movable joint")
    return joints


def _axis(joint: ElementTree.Element, source: str) -> Floats:
    """Return (3,) the unit vector in the joint's frame; URDF's default is x."""
    element = joint.find("axis")
    words = "1 0 0" if element is None else element.get("xyz", "1 0 0")
    try:
        axis = np.array([float(word) for word in words.split()])
    except ValueError:
        axis = np.zeros(0)
    if axis.shape != (3,) or not np.linalg.norm(axis) > 0.0:
        raise ModelError(
            f"{source}: the axis of joint {joint.get('name')} is '{words}', expected three "
            "numbers, not all zero"
        )
    return np.asarray(axis / np.linalg.norm(axis))


def _follows(
    joints: dict[str, ElementTree.Element], source: str
) -> dict[str, tuple[str, float, float]]:
    """Return, by the name of a mimic joint, the one it follows, the ratio and the shift."""
    found = {}
    for name, joint in joints.items():
        mimic = joint.find("mimic")
        if mimic is None:
            continue
        leader = str(mimic.get("joint"))
        if leader not in joints:
            raise ModelError(f"{source}: joint {name} mimics {leader}, which is not in the URDF")
        try:
            ratio, shift = (
                float(mimic.get(word, usual))
                for word, usual in (("multiplier", "1"), ("offset", "0"))
            )
        except ValueError as error:
            raise ModelError(f"{source}: how joint {name} mimics {leader}: {error}") from error
        found[name] = (leader, ratio, shift)
    for name in found:
        leader = name
        for _ in range(len(found) + 1):
            leader = found[leader][0] if leader in found else ""
        if leader:
            raise ModelError(f"{source}: joint {name} mimics joints that mimic each other")
    return found
