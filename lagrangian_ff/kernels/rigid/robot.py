"""A robot whose bodies a URDF describes: read with Pinocchio, and as the model file keeps it."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, fields, replace
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np

from lagrangian_ff import budget
from lagrangian_ff.arrays import Floats
from lagrangian_ff.errors import ModelError
from lagrangian_ff.kernels.base import Family, Mechanism
from lagrangian_ff.kernels.rigid.known import CORRECTION, KnownFamily
from lagrangian_ff.kernels.rigid.tree import GRAVITY, Tree

KIND = "urdf"
WHOLE = ("parent", "driver")


@dataclass(frozen=True, eq=False)
class Robot(Mechanism):
    """Known bodies on named joints.

    Attributes:
        name: of the robot.
        tree: its bodies, the k-th on the k-th of the movable joints.
        movable: (B,) names.
        follows: by the name of a mimic joint the one that it follows, the ratio and the shift.
        joints: (N,) names of the coordinates, as the recording has them; empty before that.
    """

    name: str
    tree: Tree
    movable: tuple[str, ...]
    follows: Mapping[str, tuple[str, float, float]] = field(default_factory=dict)
    joints: tuple[str, ...] = ()

    @property
    def prismatic(self) -> Floats:
        """Return (N,) 1 where a coordinate slides, 0 where it turns."""
        return np.array([self.tree.sliding[self.movable.index(name)] for name in self.joints])

    @property
    def still(self) -> tuple[str, ...]:
        """Return the joints that no coordinate moves: they are taken to stay at zero."""
        return tuple(
            name for name, driver in zip(self.movable, self.tree.driver, strict=True) if driver < 0
        )

    @property
    def tool(self) -> int:
        """Return the body farthest from the base that a coordinate moves: it carries the tool."""
        depth = [0] * len(self.movable)
        for body, parent in enumerate(self.tree.parent):
            depth[body] = 1 + (depth[parent] if parent >= 0 else 0)
        moved = [body for body in range(len(depth)) if self.tree.driver[body] >= 0]
        return max(moved, key=lambda body: (depth[body], body))

    @property
    def base_to_tool(self) -> tuple[str, ...]:
        return self.movable

    def of_joints(self, joints: tuple[str, ...], source: str) -> "Robot":
        absent = [name for name in joints if name not in self.movable]
        if absent:
            raise ModelError(
                f"the joints of {source} are not those of the URDF {self.name}: it has no "
                f"{', '.join(absent)}; recorded: {', '.join(joints)}; movable in the URDF: "
                f"{', '.join(self.movable)}; choose joints with --joints, or name them alike"
            )
        moved = [self._moved(name, joints) for name in self.movable]
        driver, ratio, shift = (np.array(values) for values in zip(*moved, strict=True))
        tree = replace(self.tree, driver=driver.astype(np.int64), ratio=ratio, shift=shift)
        return replace(self, tree=tree, joints=joints)

    def without_gravity(self) -> "Robot":
        return replace(self, tree=replace(self.tree, gravity=np.zeros(3)))

    def _moved(self, name: str, joints: tuple[str, ...]) -> tuple[int, float, float]:
        """Return the coordinate that moves a joint, its ratio and its shift."""
        ratio, shift = 1.0, 0.0
        while name not in joints:
            if name not in self.follows:
                return -1, 1.0, 0.0
            name, above, zero = self.follows[name]
            ratio, shift = ratio * above, ratio * zero + shift
        return joints.index(name), ratio, shift

    def around(self, family: Family) -> KnownFamily:
        own = () if not family.differentiable else ("deviation", "armature")
        return KnownFamily(
            self,
            family,
            f"the bodies of {self.name}, corrected by: {family.meaning}",
            searched=(*family.searched, CORRECTION),
            differentiable=(*family.differentiable, *own),
            tree=self.tree,
            prismatic=self.prismatic,
        )

    def record(self) -> dict[str, object]:
        return {
            "kind": KIND,
            "name": self.name,
            "mass": float(self.tree.inertial[:, 0].sum()),
            "prismatic": [n for n, p in zip(self.joints, self.prismatic, strict=True) if p],
            "still": list(self.still),
        }

    def stored(self) -> dict[str, object]:
        return {
            "kind": KIND,
            "name": self.name,
            "joints": list(self.joints),
            "movable": list(self.movable),
            "follows": {name: list(value) for name, value in self.follows.items()},
            "tree": {f.name: getattr(self.tree, f.name).tolist() for f in fields(self.tree)},
        }

    @classmethod
    def from_stored(cls, record: Mapping[str, Any]) -> "Robot":
        """Return the robot that `stored` wrote.

        Raises:
            ValueError: shapes or indices do not fit each other, or values are not finite.
        """
        held = record["tree"]
        arrays: dict[str, Any] = {
            f.name: np.array(held[f.name], dtype=np.int64 if f.name in WHOLE else np.float64)
            for f in fields(Tree)
        }
        movable = tuple(map(str, record["movable"]))
        shapes = {"rotation": (3, 3), "offset": (3,), "axis": (3,), "inertial": (10,)}
        for name, found in arrays.items():
            expected = (3,) if name == "gravity" else (len(movable), *shapes.get(name, ()))
            if found.shape != expected:
                raise ValueError(f"{name} of the robot has shape {found.shape}, not {expected}")
            if not np.isfinite(found).all():
                raise ValueError(f"{name} of the robot holds values that are not finite")
        joints = tuple(map(str, record["joints"]))
        parent, driver = arrays["parent"], arrays["driver"]
        # The compiled loops do not check their indices.
        if np.any(parent < -1) or np.any(parent >= np.arange(len(parent))):
            raise ValueError("a body of the robot hangs on one that does not come before it")
        if np.any(driver < -1) or np.any(driver >= len(joints)):
            raise ValueError("a body of the robot is moved by a joint that is not there")
        follows = {
            str(name): (str(leader), float(ratio), float(shift))
            for name, (leader, ratio, shift) in record["follows"].items()
        }
        return cls(str(record["name"]), Tree(**arrays), movable, follows, joints)


MOVABLE = ("revolute", "continuous", "prismatic")
FIXED = "fixed"


def read_urdf(path: "str | Path") -> Robot:
    """Return the robot that a URDF file describes.

    Raises:
        ModelError: there is no such file, it is no URDF, or has a joint of an unsupported type.
    """
    return robot_of(_text(path), str(path))


def joint_ends(joint: ElementTree.Element) -> tuple[str, str]:
    """Return the links that a joint of a URDF is between, the one nearer the base first."""
    ends = (joint.find(end) for end in ("parent", "child"))
    parent, child = ("" if end is None else end.get("link", "") for end in ends)
    return parent, child


def urdf_joints(path: "str | Path") -> dict[str, ElementTree.Element]:
    """Return the joints of a URDF by name, from the base outwards; needs no Pinocchio.

    Raises:
        ModelError: there is no such file, it is no URDF, or has a joint of an unsupported type.
    """
    joints = _joints(_root(_text(path), str(path)), str(path))
    ends = {name: joint_ends(joint) for name, joint in joints.items()}
    above = {child: parent for parent, child in ends.values()}

    def depth(name: str) -> int:
        link, count = ends[name][0], 0
        while link in above and count < len(joints):
            link, count = above[link], count + 1
        return count

    return {name: joints[name] for name in sorted(joints, key=depth)}


def _text(path: "str | Path") -> str:
    try:
        return budget.text_of(Path(path), ModelError)
    except FileNotFoundError as error:
        raise ModelError(f"no URDF file {path}") from error
    except UnicodeDecodeError as error:
        raise ModelError(f"{path} is no URDF: it is not text ({error.reason})") from error
    except OSError as error:
        raise ModelError(f"cannot read the URDF {path}: {error.strerror}") from error


def robot_of(text: str, source: str) -> Robot:
    """Return the robot of a URDF's text, whose source messages name.

    Fixed joints join their bodies. The base stands in the world as the root link does.

    Raises:
        ModelError: it is no URDF, has no movable joint or one of an unsupported type, or Pinocchio
            is not installed.
    """
    root = _root(text, source)
    joints = _joints(root, source)
    axes = {
        name: _axis(joint, source) for name, joint in joints.items() if joint.get("type") in MOVABLE
    }
    follows = _follows(joints, source)
    build = _pinocchio(source)
    try:
        model = build(text)
    except (ValueError, RuntimeError, LookupError, MemoryError) as error:
        raise ModelError(f"{source}: Pinocchio cannot read the URDF: {error}") from error
    bodies = range(1, model.njoints)
    placements = [model.jointPlacements[n] for n in bodies]
    movable = tuple(str(model.names[n]) for n in bodies)
    if strange := [name for name in movable if name not in joints]:
        raise ModelError(
            f"{source}: the name of the joint {strange[0]!r} holds a line break or tab"
        )
    sliding = np.array([float(joints[name].get("type") == "prismatic") for name in movable])
    tree = Tree(
        parent=np.array([int(model.parents[n]) - 1 for n in bodies]),
        rotation=np.array([placement.rotation for placement in placements]),
        offset=np.array([placement.translation for placement in placements]),
        axis=np.array([axes[name] for name in movable]),
        sliding=sliding,
        driver=np.arange(len(movable)),
        ratio=np.ones(len(movable)),
        shift=np.zeros(len(movable)),
        inertial=np.array([model.inertias[n].toDynamicParameters() for n in bodies]),
        gravity=np.array(GRAVITY),
    )
    for what, values in (("inertia", tree.inertial), ("place", tree.offset)):
        bad = np.flatnonzero(~(np.abs(values) <= budget.LARGEST).all(axis=1))
        if bad.size:
            raise ModelError(f"{source}: the {what} of joint {movable[bad[0]]} is not finite")
    name = str(root.get("name") or Path(source).stem)
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


class _Shallow(ElementTree.TreeBuilder):
    """Builds the tree of a text, and refuses one that is too deep while it is read."""

    def __init__(self, source: str) -> None:
        super().__init__()
        self._source, self._depth = source, 0

    def start(self, tag: str, attrs: dict[str, str]) -> ElementTree.Element:
        self._depth += 1
        if self._depth > budget.DEPTH:
            raise ModelError(
                f"{self._source}: <{tag[:40]}> lies inside {budget.DEPTH} others, expected a URDF"
            )
        return super().start(tag, attrs)

    def end(self, tag: str) -> ElementTree.Element:
        self._depth -= 1
        return super().end(tag)


def _root(text: str, source: str) -> ElementTree.Element:
    """Return a URDF's root, which is not too deep for readers that go down step by step."""
    builder = _Shallow(source)
    try:
        parser = ElementTree.XMLParser(target=builder)
        parser.feed(text)
        root = parser.close()
    except (ElementTree.ParseError, ValueError) as error:
        hint = "; expand a xacro file first: xacro FILE.xacro > FILE.urdf"
        raise ModelError(f"{source} is no URDF: it is not XML ({error}){hint}") from error
    if root.tag != "robot":
        raise ModelError(f"{source} is no URDF: its root is <{root.tag[:40]}>, expected <robot>")
    return root


def _joints(root: ElementTree.Element, source: str) -> dict[str, ElementTree.Element]:
    """Return the joints by name; all are of supported types."""
    if len(root.findall("joint")) > budget.JOINTS:
        raise ModelError(f"{source}: more than {budget.JOINTS} joints")
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
    if axis.shape != (3,) or not 0.0 < np.linalg.norm(axis) < np.inf:
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
        if not abs(ratio) + abs(shift) <= budget.LARGEST:
            raise ModelError(f"{source}: joint {name} mimics {leader} by {ratio:g} and {shift:g}")
        found[name] = (leader, ratio, shift)
    for name in found:
        leader = name
        for _ in range(len(found) + 1):
            leader = found[leader][0] if leader in found else ""
        if leader:
            raise ModelError(f"{source}: joint {name} mimics joints that mimic each other")
    return found
