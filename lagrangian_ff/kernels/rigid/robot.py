"""A robot whose bodies a URDF describes, as the model file keeps it."""

from collections.abc import Mapping
from dataclasses import dataclass, field, fields, replace
from typing import Any

import numpy as np

from lagrangian_ff.arrays import Floats
from lagrangian_ff.errors import ModelError
from lagrangian_ff.kernels.base import Family, Mechanism
from lagrangian_ff.kernels.rigid.known import CORRECTION, KnownFamily
from lagrangian_ff.kernels.rigid.tree import Tree

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

    def _moved(self, name: str, joints: tuple[str, ...]) -> tuple[int, float, float]:
        """Return the coordinate that moves a joint, its ratio and its shift."""
        if name in joints:
            return joints.index(name), 1.0, 0.0
        if name not in self.follows:
            return -1, 1.0, 0.0
        leader, ratio, shift = self.follows[name]
        driver, above, zero = self._moved(leader, joints)
        return driver, ratio * above, ratio * zero + shift

    def around(self, family: Family) -> KnownFamily:
        own = () if not family.differentiable else ("deviation", "armature")
        return KnownFamily(
            self, family, f"the bodies of {self.name}, corrected by: {family.meaning}",
            searched=(*family.searched, CORRECTION), differentiable=(*family.differentiable, *own),
            tree=self.tree, prismatic=self.prismatic,
        )  # fmt: skip

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
