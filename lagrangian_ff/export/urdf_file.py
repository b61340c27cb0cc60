"""The format `urdf`: the robot's URDF with the bodies and the friction that were found."""

from dataclasses import dataclass
from pathlib import Path
from xml.etree import ElementTree

import numpy as np

from lagrangian_ff import budget
from lagrangian_ff.arrays import Floats
from lagrangian_ff.errors import ExportError, ModelError
from lagrangian_ff.export.bodies import PLACES, Fit, fit, robot_for
from lagrangian_ff.export.result import Exported, Options, exported
from lagrangian_ff.identification import Model
from lagrangian_ff.kernels.rigid import Robot, read_urdf

NAME = "urdf"
SUMMARY = "the robot's URDF with inertials, damping and friction that come nearest to the model"
SUFFIX = ".urdf"
URDF = True
DEVIATION = 1.0
"""How far a link is expected to be from the description's, as it takes up rotors, relatively."""
ROTORS = (
    "a URDF has no place for the inertia of rotors behind gears: the links took up what they could "
    "of it, so that its inertials are for torque and not for what the links weigh; --to mjcf keeps "
    "the two apart"
)
SIGN = "friction is dry here; the model's turns over within {widths} rad/s"


@dataclass(frozen=True)
class Inertial:
    """A body as descriptions have it.

    Attributes:
        mass: kg.  centre: (3,) m, in the frame of its joint.
        inertia: (3, 3) kg·m² about the centre, in the axes of that frame.
    """

    mass: float
    centre: Floats
    inertia: Floats

    @classmethod
    def of(cls, parameters: Floats) -> "Inertial":
        """Return the body of parameters (10,) as `Tree` has them."""
        mass, centre = float(parameters[0]), parameters[1:4] / parameters[0]
        about_joint = np.zeros((3, 3))
        for value, (i, j) in zip(parameters[4:], PLACES, strict=True):
            about_joint[i, j] = about_joint[j, i] = value
        shift = mass * (centre @ centre * np.eye(3) - np.outer(centre, centre))
        return cls(mass, centre, about_joint - shift)


def read(options: Options, model: Model) -> tuple[Robot, ElementTree.Element]:
    """Return the robot of --urdf with the model's joints, and its XML with comments.

    Raises:
        ModelError: the file is no URDF, or lacks a joint of the model.
    """
    assert options.urdf is not None
    robot = robot_for(model, read_urdf(options.urdf))
    builder = ElementTree.TreeBuilder(insert_comments=True)
    parser = ElementTree.XMLParser(target=builder)
    parser.feed(budget.text_of(options.urdf, ModelError))
    return robot, parser.close()


def write(model: Model, path: Path, options: Options) -> Exported:
    """Write a copy of the URDF; see `Format`."""
    robot, root = read(options, model)
    found = fit(model, robot, armature=False, deviation=DEVIATION)
    lumped = _put_bodies(root, robot, found)
    _put_friction(root, model.joints, found)
    ElementTree.indent(root)
    ElementTree.ElementTree(root).write(path, encoding="utf-8", xml_declaration=True)
    notes = [ROTORS, sign_note(model)]
    if lumped:
        notes.append(f"the bodies of {', '.join(lumped)} are part of the links they are fixed to")
    if model.data.effort != "total":
        notes.append(f"the model's torque is that {model.data.effort}: so is this")
    return exported(
        model, NAME, (".",), found.torque, found.losses, tuple(notes), numbers(robot, model, found)
    )


def sign_note(model: Model) -> str:
    """Return how the model's dry friction differs from that of a description."""
    speeds = sorted(set(model.basis.sign_speed(len(model.joints)).tolist()))
    return SIGN.format(widths=" to ".join(f"{one:.3g}" for one in {speeds[0], speeds[-1]}))


def numbers(robot: Robot, model: Model, found: Fit) -> dict[str, object]:
    """Return what was found, as JSON holds it."""
    joints = {
        joint: {"damping": float(d), "friction": float(f), "armature": float(r)}
        for joint, d, f, r in zip(
            model.joints, found.damping, found.friction, found.armature, strict=True
        )
    }
    bodies = [Inertial.of(one) for one in found.inertial]
    links = {
        joint: {"mass": b.mass, "centre": b.centre.tolist(), "inertia": b.inertia.tolist()}
        for joint, b in zip(robot.movable, bodies, strict=True)
    }
    return {"joints": joints, "links_moved_by": links}


def _put_bodies(root: ElementTree.Element, robot: Robot, found: Fit) -> list[str]:
    """Write the inertials, and return the links whose bodies became part of others."""
    links = {str(link.get("name")): link for link in root.findall("link")}
    joints = {str(joint.get("name")): joint for joint in root.findall("joint")}
    lumped = []
    for name, parameters in zip(robot.movable, found.inertial, strict=True):
        link = _child(joints[name])
        _put_inertial(links[link], Inertial.of(parameters))
        for fixed in _fixed_to(link, joints):
            for inertial in links[fixed].findall("inertial"):
                links[fixed].remove(inertial)
                lumped.append(fixed)
    return lumped


def _put_inertial(link: ElementTree.Element, body: Inertial) -> None:
    for old in link.findall("inertial"):
        link.remove(old)
    made = ElementTree.Element("inertial")
    ElementTree.SubElement(made, "origin", xyz=_words(body.centre), rpy="0 0 0")
    ElementTree.SubElement(made, "mass", value=repr(body.mass))
    entries = {
        f"i{'xyz'[i]}{'xyz'[j]}": repr(float(body.inertia[i, j]))
        for i in range(3)
        for j in range(i, 3)
    }
    ElementTree.SubElement(made, "inertia", entries)
    link.insert(0, made)


def _put_friction(root: ElementTree.Element, names: tuple[str, ...], found: Fit) -> None:
    joints = {str(joint.get("name")): joint for joint in root.findall("joint")}
    for name, damping, friction in zip(names, found.damping, found.friction, strict=True):
        for old in joints[name].findall("dynamics"):
            joints[name].remove(old)
        values = {"damping": repr(float(damping)), "friction": repr(float(friction))}
        ElementTree.SubElement(joints[name], "dynamics", values)


def _child(joint: ElementTree.Element) -> str:
    child = joint.find("child")
    if child is None:
        raise ExportError(f"joint {joint.get('name')} of the URDF has no child")
    return str(child.get("link"))


def _fixed_to(link: str, joints: dict[str, ElementTree.Element]) -> list[str]:
    """Return the links that fixed joints fasten to a link, directly or by others."""
    found = []
    for joint in joints.values():
        parent = joint.find("parent")
        if joint.get("type") == "fixed" and parent is not None and parent.get("link") == link:
            child = _child(joint)
            found += [child, *_fixed_to(child, joints)]
    return found


def _words(values: Floats) -> str:
    return " ".join(repr(float(value)) for value in values)
