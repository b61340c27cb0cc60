"""A picture of the arm, drawn by PyBullet's software renderer."""

from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path

import matplotlib
import numpy as np
from matplotlib import image
from numpy.typing import NDArray

from lagrangian_ff.arm.body import Body
from lagrangian_ff.arm.bullet import pybullet
from lagrangian_ff.arm.description import Loads
from lagrangian_ff.arrays import Floats

Mesh = tuple[Floats, Floats, NDArray[np.int64]]
Pose = tuple[Sequence[float], Sequence[float]]

POSE: tuple[float, ...] = (0.35, 0.35, 0.0, 0.5, 0.6, 0.4)  # rad
BACKGROUND = np.array([0.957, 0.965, 0.973])
OVERSAMPLING = 3
FLOOR_COLOUR = (0.86, 0.88, 0.90, 1.0)
FLOOR_RADIUS = 0.48  # m
SIDES = 64
CHAMFER = 0.0035  # m


def picture(
    path: str | Path, *, q: Sequence[float] | Floats = POSE, size: int = 720, loads: Loads = None
) -> None:
    """Draw the arm and its loads at a pose (6,) rad into a PNG file of `size` times `size` pixels.

    Raises:
        ArmError: a load on no link of the arm.
        OSError: the file cannot be written.
    """
    matplotlib.use("Agg", force=False)
    with Body(loads) as body:
        body.set_state(np.asarray(q, dtype=np.float64), np.zeros(6))
        _replace_by_fine_meshes(body)
        pixels = _render(body, size * OVERSAMPLING)
    fine = pixels.reshape(size, OVERSAMPLING, size, OVERSAMPLING, 3)
    image.imsave(str(path), np.clip(fine.mean(axis=(1, 3)), 0.0, 1.0))


def _render(body: Body, size: int) -> Floats:
    view = pybullet.computeViewMatrix((1.6, -1.75, 1.05), (0.16, 0.0, 0.47), (0.0, 0.0, 1.0))
    lens = pybullet.computeProjectionMatrixFOV(33.0, 1.0, 0.5, 6.0)
    _, _, colours, _, segments = pybullet.getCameraImage(
        size,
        size,
        view,
        lens,
        lightDirection=(1.2, -2.0, 2.6),
        lightDistance=4.0,
        lightAmbientCoeff=0.62,
        lightDiffuseCoeff=0.42,
        lightSpecularCoeff=0.12,
        shadow=1,
        renderer=pybullet.ER_TINY_RENDERER,
        physicsClientId=body.client,
    )
    pixels = np.reshape(colours, (size, size, 4))[:, :, :3] / 255.0
    empty = np.reshape(segments, (size, size)) < 0
    pixels[empty] = BACKGROUND
    return pixels


def _replace_by_fine_meshes(body: Body) -> None:
    """Replace every shape: the renderer's own cylinders have visible corners."""
    args = {"physicsClientId": body.client}
    for shape in pybullet.getVisualShapeData(body.id, **args):
        _, link, kind, size, _, place, turn, colour = shape[:8]
        position, orientation = _frame(body, link)
        where = pybullet.multiplyTransforms(position, orientation, place, turn)
        _show(body, mesh(kind, size), colour, where)
    pybullet.removeBody(body.id, **args)
    disc = mesh(pybullet.GEOM_CYLINDER, (0.01, FLOOR_RADIUS))
    _show(body, disc, FLOOR_COLOUR, ((0.0, 0.0, -0.005), (0.0, 0.0, 0.0, 1.0)))


def _show(body: Body, shape: Mesh, colour: Sequence[float], where: Pose) -> None:
    vertices, normals, triangles = shape
    visual = pybullet.createVisualShape(
        pybullet.GEOM_MESH,
        vertices=vertices.tolist(),
        normals=normals.tolist(),
        indices=triangles.ravel().tolist(),
        rgbaColor=colour,
        physicsClientId=body.client,
    )
    pybullet.createMultiBody(0, -1, visual, *where, physicsClientId=body.client)


def _frame(body: Body, link: int) -> Pose:
    if link < 0:
        return (0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0)
    state = pybullet.getLinkState(
        body.id, link, computeForwardKinematics=1, physicsClientId=body.client
    )
    return state[4], state[5]


def mesh(kind: int, size: Sequence[float]) -> Mesh:
    """Return vertices (V, 3) and normals (V, 3), m, and triangles of a shape of PyBullet."""
    if kind == pybullet.GEOM_BOX:
        return _box(np.asarray(size))
    if kind == pybullet.GEOM_SPHERE:
        angle = np.linspace(-np.pi / 2, np.pi / 2, SIDES // 2)
        return _turned(size[0] * np.stack([np.cos(angle), np.sin(angle)], axis=1), smooth=True)
    length, radius = size[0], size[1]
    c = min(CHAMFER, 0.3 * length)
    half = 0.5 * length
    corners = [(0, -half), (radius - c, -half), (radius, c - half)]
    profile = np.array(corners + [(r, -z) for r, z in reversed(corners)])
    return _turned(profile, smooth=False)


def _turned(profile: Floats, *, smooth: bool) -> Mesh:
    """Return the solid of a profile of (radius, height) turned about z."""
    around = np.linspace(0.0, 2.0 * np.pi, SIDES + 1)
    ring = np.stack([np.cos(around), np.sin(around)], axis=1)
    vertices, normals, triangles = [], [], []
    count = 0
    for below, above in pairwise(profile):
        across = above - below
        flat = np.array([across[1], -across[0]]) / np.linalg.norm(across)
        for end in (below, above):
            outward = end / np.linalg.norm(end) if smooth else flat
            vertices.append(np.column_stack([ring * end[0], np.full(SIDES + 1, end[1])]))
            normals.append(np.column_stack([ring * outward[0], np.full(SIDES + 1, outward[1])]))
        low = count + np.arange(SIDES)
        high = low + SIDES + 1
        triangles.append(np.column_stack([low, low + 1, high + 1]))
        triangles.append(np.column_stack([low, high + 1, high]))
        count += 2 * (SIDES + 1)
    return np.concatenate(vertices), np.concatenate(normals), np.concatenate(triangles)


def _box(size: Floats) -> Mesh:
    """Return a box with chamfered edges: six faces, twelve edges, eight corners."""
    half = 0.5 * size
    inner = half - CHAMFER
    vertices: list[Floats] = []
    normals: list[Floats] = []
    triangles: list[tuple[int, int, int]] = []
    signs = np.array([(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], dtype=float)

    def corner(sign: Floats, axis: int) -> Floats:
        """Return one of three points that replace a corner: on the face across `axis`."""
        point = sign * inner
        point[axis] = sign[axis] * half[axis]
        return point

    def add(points: list[Floats]) -> None:
        normal = np.cross(points[1] - points[0], points[2] - points[0])
        if normal @ np.mean(points, axis=0) < 0:
            points, normal = points[::-1], -normal
        first = len(vertices)
        vertices.extend(points)
        normals.extend([normal / np.linalg.norm(normal)] * len(points))
        triangles.extend((first, first + k, first + k + 1) for k in range(1, len(points) - 1))

    for axis in range(3):
        u, v = (axis + 1) % 3, (axis + 2) % 3
        for side in (-1.0, 1.0):
            face = []
            for a, b in ((-1, -1), (1, -1), (1, 1), (-1, 1)):
                sign = np.zeros(3)
                sign[[axis, u, v]] = side, a, b
                face.append(corner(sign, axis))
            add(face)
            for other in (-1.0, 1.0):
                edge = []
                for along, plane in ((-1, axis), (1, axis), (1, u), (-1, u)):
                    sign = np.zeros(3)
                    sign[[axis, u, v]] = side, other, along
                    edge.append(corner(sign, plane))
                add(edge)
    for sign in signs:
        add([corner(sign, axis) for axis in range(3)])
    return np.array(vertices), np.array(normals), np.array(triangles)
