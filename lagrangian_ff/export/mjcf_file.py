"""The format `mjcf`: a MuJoCo model of the arm's joints, bodies, rotors, friction and motors."""

from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import scipy

from lagrangian_ff.arrays import Floats
from lagrangian_ff.export.bodies import Fit, fit
from lagrangian_ff.export.result import Exported, Options, exported
from lagrangian_ff.export.urdf_file import Inertial, numbers, read, sign_note
from lagrangian_ff.identification import Model
from lagrangian_ff.kernels.rigid import Robot

NAME = "mjcf"
SUMMARY = "a MuJoCo model of the URDF's joints with inertials, armature, damping and friction"
SUFFIX = ".xml"
URDF = True
NO_SHAPES = "it has no shapes: copy the attributes of body and joint into a model that has, by name"


def write(model: Model, path: Path, options: Options) -> Exported:
    """Write a MuJoCo model; see `Format`."""
    robot, urdf = read(options, model)
    found = fit(model, robot, armature=True)
    gains = torque_gains(model)
    root = _document(robot, urdf, model, found, gains)
    ElementTree.indent(root)
    ElementTree.ElementTree(root).write(path, encoding="utf-8")
    notes = [NO_SHAPES, sign_note(model)]
    return exported(
        model,
        NAME,
        (".",),
        found.torque,
        found.losses,
        tuple(notes),
        {**numbers(robot, model, found), "torque_gain": gains.tolist()},
    )


def torque_gains(model: Model) -> Floats:
    """Return (N,) N·m at the joint per N·m that is commanded: what `torque_gain` found.

    A torque that is measured 1 + g times too large is commanded 1 + g times too small.
    """
    gains = np.ones(len(model.joints))
    for term, place in model.basis.slices():
        if term.effect.name == "torque_gain":
            gains[term.joint] = 1.0 / (1.0 + float(model.coefficients[place][0]))
    return gains


def _document(
    robot: Robot, urdf: ElementTree.Element, model: Model, found: Fit, gains: Floats
) -> ElementTree.Element:
    root = ElementTree.Element("mujoco", model=robot.name)
    ElementTree.SubElement(root, "compiler", angle="radian", autolimits="true")
    ElementTree.SubElement(root, "option", gravity=_words(robot.tree.gravity))
    limits = {str(j.get("name")): j.find("limit") for j in urdf.findall("joint")}
    holders = [ElementTree.SubElement(root, "worldbody")]
    for body, name in enumerate(robot.movable):
        parent = holders[1 + int(robot.tree.parent[body])]
        holders.append(_body(robot, body, parent, found, limits[name], model.joints))
    if robot.follows:
        equality = ElementTree.SubElement(root, "equality")
        for name, (leader, ratio, shift) in robot.follows.items():
            ElementTree.SubElement(
                equality, "joint", joint1=name, joint2=leader,
                polycoef=_words(np.array([shift, ratio, 0.0, 0.0, 0.0])),
            )  # fmt: skip
    actuator = ElementTree.SubElement(root, "actuator")
    for joint, gain in zip(model.joints, gains, strict=True):
        motor = {"name": joint, "joint": joint, "gear": repr(float(gain))}
        limit = limits[joint]
        if limit is not None and float(limit.get("effort", "0")) > 0.0:
            motor["ctrlrange"] = _words(np.array([-1.0, 1.0]) * float(limit.get("effort", "0")))
        ElementTree.SubElement(actuator, "motor", motor)
    return root


def _body(
    robot: Robot,
    body: int,
    parent: ElementTree.Element,
    found: Fit,
    limit: ElementTree.Element | None,
    names: tuple[str, ...],
) -> ElementTree.Element:
    """Add a body with its joint to its parent, and return it."""
    tree, name = robot.tree, robot.movable[body]
    turn = scipy.spatial.transform.Rotation.from_matrix(tree.rotation[body]).as_quat()
    made = ElementTree.SubElement(
        parent, "body", name=f"link of {name}", pos=_words(tree.offset[body]),
        quat=_words(turn[[3, 0, 1, 2]]),
    )  # fmt: skip
    held = Inertial.of(found.inertial[body])
    rows, columns = (0, 1, 2, 0, 0, 1), (0, 1, 2, 1, 2, 2)
    ElementTree.SubElement(
        made, "inertial", pos=_words(held.centre), mass=repr(held.mass),
        fullinertia=_words(held.inertia[rows, columns]),
    )  # fmt: skip
    joint = {
        "name": name,
        "type": "slide" if tree.sliding[body] > 0.0 else "hinge",
        "axis": _words(tree.axis[body]),
    }
    if limit is not None and limit.get("lower") is not None and limit.get("upper") is not None:
        joint["range"] = f"{limit.get('lower')} {limit.get('upper')}"
    if name in names:
        n = names.index(name)
        joint |= {
            "armature": repr(float(found.armature[n])),
            "damping": repr(float(found.damping[n])),
            "frictionloss": repr(float(found.friction[n])),
        }
    ElementTree.SubElement(made, "joint", joint)
    return made


def _words(values: Floats) -> str:
    return " ".join(repr(float(value)) for value in values)
