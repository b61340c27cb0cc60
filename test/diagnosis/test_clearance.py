"""What touches on a path, by the shapes of a URDF; and the limits that it gives."""

import itertools
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from lagrangian_ff.diagnosis.excite import Box, Clearance, Limits, floor_at, urdf_limits
from lagrangian_ff.errors import ModelError

pytest.importorskip("pinocchio", reason="Pinocchio, the extra urdf, is not installed")

Floats = NDArray[np.float64]

JOINTS = ("shoulder", "elbow", "wrist")
INERTIAL = (
    '<inertial><mass value="1"/><inertia ixx="0.1" iyy="0.1" izz="0.1" ixy="0" ixz="0" iyz="0"/>'
    "</inertial>"
)
BAR = (
    '<collision><origin xyz="0.25 0 0"/><geometry><box size="0.4 0.06 0.06"/></geometry>'
    "</collision>"
)


def link(name: str, shape: str = BAR) -> str:
    return f'<link name="{name}">{INERTIAL}{shape}</link>'


def joint(name: str, parent: str, child: str, x: float, rest: str, kind: str = "revolute") -> str:
    return (
        f'<joint name="{name}" type="{kind}"><origin xyz="{x} 0 0"/><parent link="{parent}"/>'
        f'<child link="{child}"/><axis xyz="0 0 1"/>{rest}</joint>'
    )


def urdf(path: Path, shape: str = BAR) -> Path:
    """Three bars of 0.5 m in a plane, each turning at the end of the one before."""
    limit = '<limit lower="-2" upper="2.5" velocity="1.5" effort="20"/>'
    parts = [
        '<link name="base"/>',
        *(link(name, shape) for name in ("upper", "lower", "hand")),
        joint("shoulder", "base", "upper", 0.0, "", "continuous"),
        joint("elbow", "upper", "lower", 0.5, limit),
        joint("wrist", "lower", "hand", 0.5, limit),
    ]
    path.write_text(f'<robot name="bars">{"".join(parts)}</robot>')
    return path


@pytest.fixture
def bars(tmp_path: Path) -> Path:
    return urdf(tmp_path / "bars.urdf")


STRAIGHT = np.zeros((1, 3))


def box_stl(path: Path, low: tuple[float, ...], high: tuple[float, ...]) -> None:
    """Write a box as triangles."""
    corners = np.array(list(itertools.product(*zip(low, high, strict=True))))
    sides = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    lines = ["solid box"]
    for a, b, c, d in sides:
        for triangle in ((a, b, c), (a, c, d)):
            vertices = [f"vertex {x} {y} {z}" for x, y, z in corners[list(triangle)]]
            lines += ["facet normal 0 0 0", "outer loop", *vertices, "endloop", "endfacet"]
    path.write_text("\n".join([*lines, "endsolid box", ""]))


def test_links_that_fold_onto_each_other_touch(bars: Path) -> None:
    clear = Clearance.of(bars, JOINTS, STRAIGHT)
    assert clear(STRAIGHT) == ""
    folded = np.array([[0.0, 2.3, 2.3]])
    assert clear(np.vstack([STRAIGHT, folded])) == "upper_0 and hand_0"


def test_what_the_arm_has_done_is_no_contact(bars: Path) -> None:
    folded = np.array([[0.0, 2.3, 2.3]])
    assert Clearance.of(bars, JOINTS, folded)(folded) == ""


@pytest.mark.parametrize("turn", [0.0, 1.0, 2.5, -3.0])
def test_a_box_is_found_wherever_the_first_joint_turns(bars: Path, turn: float) -> None:
    """It has no ends: Pinocchio has a cosine and a sine of it."""
    at = 1.3 * np.array([np.cos(turn), np.sin(turn)])
    box = Box((float(at[0]), float(at[1]), 0.0), (0.05, 0.05, 0.05))
    clear = Clearance.of(bars, JOINTS, np.array([[turn + 1.5, 0.0, 0.0]]), [box])
    assert clear(np.array([[turn, 0.0, 0.0]])) == "hand_0 and obstacle 1"
    assert clear(np.array([[turn + 0.5, 0.0, 0.0]])) == ""


def test_the_margin_is_kept_from_a_floor(bars: Path) -> None:
    """The bars are 3 cm above the middle, and so below."""
    for gap, touches in ((0.015, True), (0.025, False)):
        clear = Clearance.of(bars, JOINTS, np.empty((0, 3)), [floor_at(-0.03 - gap)], margin=0.02)
        assert bool(clear(STRAIGHT)) is touches


def test_joints_are_found_by_name(bars: Path) -> None:
    """In another order, and some of them only: the others stay at zero."""
    box = Box((1.3, 0.0, 0.0), (0.05, 0.05, 0.05))
    clear = Clearance.of(bars, ("elbow", "shoulder"), np.array([[1.0, 1.0]]), [box])
    assert clear(np.array([[0.0, 0.0]])) == "hand_0 and obstacle 1"
    assert clear(np.array([[1.2, 0.0]])) == ""


def test_limits_of_the_urdf_are_kept_too(bars: Path) -> None:
    ones = np.ones(3)
    seen = Limits(-3.0 * ones, 3.0 * ones, 2.0 * ones, 9.0 * ones, 90.0 * ones, 15.0 * ones)
    found = urdf_limits(bars, JOINTS, seen)
    np.testing.assert_allclose(found.q_low, [-3.0, -2.0, -2.0])
    np.testing.assert_allclose(found.q_high, [3.0, 2.5, 2.5])
    np.testing.assert_allclose(found.qd_max, [2.0, 1.5, 1.5])
    assert found.tau_max is not None
    np.testing.assert_allclose(found.tau_max, 15.0)
    assert found.jerk_max is seen.jerk_max


@pytest.mark.parametrize("name", ["../meshes/bar.stl", "package://bars_description/meshes/bar.stl"])
def test_meshes_are_found_beside_the_file_and_in_its_package(tmp_path: Path, name: str) -> None:
    package = tmp_path / "bars_description"
    for folder in ("urdf", "meshes"):
        (package / folder).mkdir(parents=True)
    box_stl(package / "meshes" / "bar.stl", (0.05, -0.03, -0.03), (0.45, 0.03, 0.03))
    shape = f'<collision><geometry><mesh filename="{name}"/></geometry></collision>'
    clear = Clearance.of(urdf(package / "urdf" / "bars.urdf", shape), JOINTS, STRAIGHT)
    assert not clear(STRAIGHT)
    assert "hand" in clear(np.array([[0.0, 2.5, 2.5]]))


def test_mistakes(tmp_path: Path, bars: Path) -> None:
    with pytest.raises(ModelError, match="no link has a collision shape"):
        Clearance.of(urdf(tmp_path / "bare.urdf", ""), JOINTS, STRAIGHT)
    with pytest.raises(ModelError, match="it has no thumb"):
        Clearance.of(bars, ("thumb",), STRAIGHT)
    mesh = '<collision><geometry><mesh filename="package://none/x.stl"/></geometry></collision>'
    with pytest.raises(ModelError, match="ROS_PACKAGE_PATH"):
        Clearance.of(urdf(tmp_path / "mesh.urdf", mesh), JOINTS, STRAIGHT)
