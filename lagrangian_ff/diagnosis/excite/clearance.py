"""Contacts of a path with the robot itself and its surroundings, by the shapes of its URDF."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from lagrangian_ff.arrays import Floats
from lagrangian_ff.diagnosis.excite.path import Limits
from lagrangian_ff.errors import ModelError
from lagrangian_ff.kernels.rigid.robot import Robot, read_urdf, urdf_joints

MARGIN = 0.02
"""m that links keep from each other and from obstacles, if nothing else is said."""
LOOKED_AT = 200
"""Poses of the model's own data at which links that touch may touch."""
LARGE = 20.0
"""m, thickness of a floor."""
AROUND = 4
"""Folders, from that of a URDF upwards, in which its meshes are looked for: a description's package
is one or two above its `urdf`."""
FIXED = 0
"""Pinocchio's joint of what does not move."""


@dataclass(frozen=True)
class Box:
    """An obstacle along the axes of the base.

    Attributes:
        centre: m.  size: m, the whole edges.
    """

    centre: tuple[float, float, float]
    size: tuple[float, float, float]


def floor_at(z: float) -> Box:
    """Return a floor whose upper face is at z, m."""
    return Box((0.0, 0.0, z - 0.5 * LARGE), (LARGE, LARGE, LARGE))


@dataclass(frozen=True)
class Clearance:
    """The shapes of a robot and its obstacles; called with a path (M, N) rad it says what touches.

    Links that hang together, and pairs that are near each other in poses that the arm has been in,
    are not compared.
    """

    robot: Robot
    _model: Any
    _data: Any
    _geometry: Any
    _shapes: Any

    @classmethod
    def of(
        cls,
        path: Path,
        joints: Sequence[str],
        seen: Floats,
        obstacles: Sequence[Box] = (),
        margin: float = MARGIN,
    ) -> "Clearance":
        """Return the shapes of a URDF.

        Args:
            joints: N names, as paths have them.
            seen: (M, N) rad, poses that the arm has been in.
            obstacles: fixed to the base.  margin: m, what is nearer counts as touching.

        Raises:
            ModelError: no such file or no URDF, a joint that it lacks, no collision shapes, meshes
                that are not found, or Pinocchio is not installed.
        """
        robot = read_urdf(path).of_joints(tuple(joints), "the model")
        import pinocchio

        model = pinocchio.buildModelFromUrdf(str(path))
        around = [str(folder) for folder in path.resolve().parents[:AROUND]]
        try:
            kind = pinocchio.GeometryType.COLLISION
            geometry = pinocchio.buildGeomFromUrdf(model, str(path), kind, package_dirs=around)
        except (ValueError, RuntimeError) as error:
            raise ModelError(
                f"{path}: its collision shapes cannot be read: {error}; meshes are looked for "
                f"beside it, in the {AROUND - 1} folders around it, and in the packages of "
                "AMENT_PREFIX_PATH and ROS_PACKAGE_PATH"
            ) from error
        if not len(geometry.geometryObjects):
            raise ModelError(f"{path}: no link has a collision shape: nothing can be checked")
        links = len(geometry.geometryObjects)
        for number, box in enumerate(obstacles):
            _add(geometry, f"obstacle {number + 1}", box)
        for first, second in _pairs(model, geometry, links):
            geometry.addCollisionPair(pinocchio.CollisionPair(first, second))
        shapes = pinocchio.GeometryData(geometry)
        for request in shapes.collisionRequests:
            request.security_margin = margin
        made = cls(robot, model, model.createData(), geometry, shapes)
        made._leave_out(seen[:: max(1, len(seen) // LOOKED_AT)], links)
        return made

    def _leave_out(self, seen: Floats, links: int) -> None:
        """Compare no pair of links that is near in a seen pose."""
        touching: set[int] = set()
        for q in seen:
            touching.update(self._touching(q, first=False))
        pairs = self._geometry.collisionPairs
        for number in touching:
            if max(pairs[number].first, pairs[number].second) < links:
                self._shapes.deactivateCollisionPair(number)

    def __call__(self, path: Floats) -> str:
        for q in path:
            for number in self._touching(q, first=True):
                pair = self._geometry.collisionPairs[number]
                objects = self._geometry.geometryObjects
                return f"{objects[pair.first].name} and {objects[pair.second].name}"
        return ""

    def _touching(self, q: Floats, *, first: bool) -> list[int]:
        """Return the numbers of the pairs that touch at (N,) rad."""
        import pinocchio

        parts = self._model, self._data, self._geometry, self._shapes
        if not pinocchio.computeCollisions(*parts, self._configuration(q), first):
            return []
        active = self._shapes.activeCollisionPairs
        results = self._shapes.collisionResults
        return [n for n in range(len(results)) if active[n] and results[n].isCollision()]

    def _configuration(self, q: Floats) -> Floats:
        """Return Pinocchio's configuration: a joint without ends is a cosine and a sine."""
        tree, out = self.robot.tree, np.zeros(self._model.nq)
        for body, driver in enumerate(tree.driver.tolist()):
            angle = tree.ratio[body] * q[driver] + tree.shift[body] if driver >= 0 else 0.0
            joint = self._model.joints[self._model.getJointId(self.robot.movable[body])]
            wide = (np.cos(angle), np.sin(angle)) if joint.nq == 2 else (angle,)
            out[joint.idx_q : joint.idx_q + joint.nq] = wide
        return out


def _add(geometry: Any, name: str, box: Box) -> None:
    import pinocchio

    shapes = getattr(pinocchio, "coal", None) or pinocchio.hppfcl  # the name before 3.5
    place = pinocchio.SE3(np.eye(3), np.array(box.centre))
    shape = shapes.Box(*box.size)
    geometry.addGeometryObject(pinocchio.GeometryObject(name, FIXED, place, shape))


def _pairs(model: Any, geometry: Any, links: int) -> list[tuple[int, int]]:
    """Return the pairs of shapes to compare: neither fixed to one joint nor to neighbours."""
    parents = [one.parentJoint for one in geometry.geometryObjects]
    found = []
    for second, joint in enumerate(parents):
        for first, other in enumerate(parents[:second]):
            near = other in (joint, model.parents[joint]) or model.parents[other] == joint
            obstacle = second >= links > first and other != FIXED
            if obstacle or (second < links and not near):
                found.append((first, second))
    return found


def urdf_limits(path: Path, joints: Sequence[str], limits: Limits) -> Limits:
    """Return limits that are also those of a URDF, where it gives any.

    Raises:
        ModelError: the file is no URDF.
    """
    found = urdf_joints(path)
    low, high, speed = limits.q_low.copy(), limits.q_high.copy(), limits.qd_max.copy()
    tau = np.full(len(low), np.inf) if limits.tau_max is None else limits.tau_max.copy()
    for n, name in enumerate(joints):
        given = found[name].find("limit") if name in found else None
        if given is None:
            continue
        if found[name].get("type") != "continuous":
            low[n] = max(low[n], float(given.get("lower", "0")))
            high[n] = min(high[n], float(given.get("upper", "0")))
        speed[n] = min(speed[n], float(given.get("velocity", "inf")) or np.inf)
        tau[n] = min(tau[n], float(given.get("effort", "inf")) or np.inf)
    return Limits(low, high, speed, limits.qdd_max, limits.jerk_max, tau)
