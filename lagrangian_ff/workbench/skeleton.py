"""The joints of an arm as its URDF places them, to draw it: no masses, no meshes."""

from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np

from lagrangian_ff import budget
from lagrangian_ff.arrays import Floats
from lagrangian_ff.errors import ModelError

MOST = 200  # joints


def read_skeleton(file: Path) -> list[dict[str, Any]]:
    """Return the joints of a URDF, each after the one that carries it.

    Returns:
        For each joint `name`, `kind` (as URDF has it), `parent` (the place of the joint that
        carries it, -1 for the base), `origin` (3,) m and `rotation` (9,) row by row from there, and
        `axis` (3,).

    Raises:
        ModelError: the file is no URDF of an arm.
    """
    try:
        root = ElementTree.fromstring(budget.text_of(file, ModelError))
        found = {str(_child(one, "child")): one for one in root.findall("joint")}
        if root.tag != "robot" or not found or len(found) > MOST:
            raise ValueError(f"{len(found)} joints in <{root.tag}>")
        placed: dict[str, int] = {}
        joints: list[dict[str, Any]] = []
        while len(placed) < len(found):
            ready = [
                link for link, joint in found.items()
                if link not in placed
                and (_child(joint, "parent") in placed or _child(joint, "parent") not in found)
            ]  # fmt: skip
            if not ready:
                raise ValueError("its joints go round in a circle")
            for link in ready:
                placed[link] = len(joints)
                joints.append(_joint(found[link], placed))
        return joints
    except (ElementTree.ParseError, ValueError, KeyError, OSError) as error:
        raise ModelError(f"{file}: expected the URDF of an arm; {error}") from error


def _child(joint: ElementTree.Element, name: str) -> str:
    element = joint.find(name)
    if element is None:
        raise ValueError(f"a joint has no {name}")
    return element.get("link", "")


def _joint(joint: ElementTree.Element, placed: dict[str, int]) -> dict[str, Any]:
    origin, axis = joint.find("origin"), joint.find("axis")
    given = {} if origin is None else origin.attrib
    roll, pitch, yaw = _three(given.get("rpy", "0 0 0"))
    turned = _turn(2, yaw) @ _turn(1, pitch) @ _turn(0, roll)
    return {
        "name": joint.get("name", ""),
        "kind": joint.get("type", "fixed"),
        "parent": placed.get(_child(joint, "parent"), -1),
        "origin": _three(given.get("xyz", "0 0 0")),
        "rotation": turned.ravel().tolist(),
        "axis": _three("1 0 0" if axis is None else axis.get("xyz", "1 0 0")),
    }


def _three(text: str) -> list[float]:
    values = [float(one) for one in text.split()]
    if len(values) != 3 or not np.isfinite(values).all():
        raise ValueError(f"{text!r} is no vector")
    return values


def _turn(axis: int, angle: float) -> Floats:
    """Return the rotation (3, 3) about an axis of the frame."""
    made = np.eye(3)
    a, b = (axis + 1) % 3, (axis + 2) % 3
    made[a, a] = made[b, b] = np.cos(angle)
    made[b, a], made[a, b] = np.sin(angle), -np.sin(angle)
    return made
