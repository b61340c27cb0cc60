"""What an arm is allowed: from a URDF, from a file, or within both; never more than is safe."""

from pathlib import Path

import numpy as np
import pytest

from lagrangian_ff.arm.description import JOINTS, URDF, limits
from lagrangian_ff.errors import UserError
from lagrangian_ff.investigation.allowed import (
    UNTIL_FAST,
    allowed,
    arm_names,
    file_names,
    urdf_names,
)

FILE = """
joint_limits:
  joint_2:
    {min_position: -0.5, max_position: 0.7, max_velocity: 1.0, max_acceleration: 1.0}
  joint_1: {min_position: -9.0, max_position: 1, max_velocity: 9.0, has_jerk_limits: false}
"""
INSIDE = 0.05


@pytest.fixture
def file(tmp_path: Path) -> Path:
    path = tmp_path / "joint_limits.yaml"
    path.write_text(FILE)
    return path


def test_of_a_urdf_a_share_of_the_speed_is_allowed_a_margin_inside() -> None:
    arm, found = limits(), allowed(JOINTS, URDF, speed=0.4)
    inside = INSIDE * (arm.upper - arm.lower)
    np.testing.assert_allclose(found.q_low, arm.lower + inside)
    np.testing.assert_allclose(found.q_high, arm.upper - inside)
    np.testing.assert_allclose(found.qd_max, 0.95 * 0.4 * arm.velocity)
    np.testing.assert_allclose(found.qdd_max, found.qd_max / UNTIL_FAST)
    assert found.tau_max is not None
    assert (found.tau_max < 0.85 * arm.effort).all()


def test_a_file_gives_the_order_and_what_it_names(file: Path) -> None:
    assert file_names(file) == ("joint_2", "joint_1")
    found = allowed(file_names(file), file=file, speed=1.0)
    np.testing.assert_allclose(found.q_high, [0.7 - INSIDE * 1.2, 1.0 - INSIDE * 10.0])
    np.testing.assert_allclose(found.qdd_max, [0.95 * 1.0, 0.95 * 9.0 / UNTIL_FAST])
    assert found.tau_max is None


def test_of_both_the_narrower_is_allowed(file: Path) -> None:
    arm, found = limits(), allowed(("joint_1", "joint_2"), URDF, file, speed=1.0)
    assert found.q_low[0] > arm.lower[0]
    assert found.q_high[0] < 1.0
    assert (found.q_low[1], found.qd_max[1]) == pytest.approx((-0.5 + INSIDE * 1.2, 0.95))
    assert found.qd_max[0] == pytest.approx(0.95 * arm.velocity[0])


def test_the_joints_of_a_urdf_go_from_the_base_to_the_tool(tmp_path: Path) -> None:
    assert urdf_names(URDF, [*JOINTS[::-1], "gripper"]) == JOINTS
    assert urdf_names(URDF, JOINTS[2:4]) == JOINTS[2:4]
    with pytest.raises(UserError, match="none of its joints is heard of; heard: a, b"):
        urdf_names(URDF, ["a", "b"])
    mixed = """<robot name="r"><link name="l0"/><link name="l1"/><link name="l2"/>
      <joint name="second" type="continuous"><parent link="l1"/><child link="l2"/>
        <limit velocity="2" effort="3"/></joint>
      <joint name="first" type="revolute"><parent link="l0"/><child link="l1"/>
        <limit lower="-1" upper="1" velocity="2" effort="3"/></joint></robot>"""
    path = tmp_path / "r.urdf"
    path.write_text(mixed)
    assert urdf_names(path, ["second", "first"]) == ("first", "second")
    found = allowed(("first", "second"), path)
    assert found.q_high[1] == pytest.approx(np.pi - INSIDE * 2 * np.pi)


def forked(path: Path, kinds: dict[str, tuple[str, str, str]]) -> Path:
    """Write a URDF of joints, each with its type and the links that it is between."""
    links = {link for _, *ends in kinds.values() for link in ends}
    parts = [f'<link name="{link}"/>' for link in sorted(links)]
    parts += [
        f'<joint name="{name}" type="{kind}"><parent link="{parent}"/>'
        f'<child link="{child}"/></joint>'
        for name, (kind, parent, child) in kinds.items()
    ]
    path.write_text(f'<robot name="r">{"".join(parts)}</robot>')
    return path


HAND = {
    "left": ("prismatic", "hand", "l"),
    "right": ("prismatic", "hand", "r"),
    "camera": ("fixed", "wrist", "c"),
    "flange": ("fixed", "wrist", "hand"),
    "two": ("revolute", "upper", "wrist"),
    "one": ("revolute", "base", "upper"),
    "mount": ("fixed", "world", "base"),
}


def test_fingers_are_no_joints_of_the_arm(tmp_path: Path, file: Path) -> None:
    hand, heard = forked(tmp_path / "hand.urdf", HAND), [*HAND][::-1]
    assert urdf_names(hand, heard) == ("one", "two")
    assert urdf_names(hand, heard, forks=True) == ("one", "two", "left", "right")
    cart = {"wheel": ("continuous", "base", "w"), "turn": ("revolute", "base", "a")}
    rolling = forked(tmp_path / "cart.urdf", cart)
    assert urdf_names(rolling, [*cart]) == ("wheel", "turn"), "it forks at its base"
    assert arm_names(heard, (), hand, None) == ("one", "two")
    assert arm_names(heard, ("left", "two"), hand, None) == ("two", "left")
    assert arm_names(heard, ("joint_1",), hand, file) == ("joint_1",)
    assert arm_names(heard, (), hand, file) == file_names(file)
    with pytest.raises(UserError, match=r"takes none of its joints: track"):
        arm_names(heard, ("track",), hand, None)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("a: 1", "expected joint_limits"),
        ("joint_limits: {}", "is empty"),
        ("joint_limits: {other: {max_velocity: 1}}", "no limits of a; of other"),
        ("joint_limits: {a: {min_position: 0, max_position: 1}}", "a has no max_velocity"),
        (
            "joint_limits: {a: {min_position: 0, max_position: x, max_velocity: 1}}",
            "max_position: expected numbers",
        ),
        (
            "joint_limits: {a: {min_position: 1, max_position: 0, max_velocity: 1}}",
            "leave no room to move",
        ),
        ("joint_limits: [", "expected joint_limits"),
    ],
)
def test_a_bad_file_is_named(text: str, words: str, tmp_path: Path) -> None:
    path = tmp_path / "bad.yaml"
    path.write_text(text)
    with pytest.raises(UserError, match=words):
        allowed(("a",), file=path)


@pytest.mark.parametrize("speed", [0.0, 1.5, float("nan")])
def test_a_speed_that_is_no_share_is_refused(speed: float) -> None:
    with pytest.raises(UserError, match="expected a share"):
        allowed(JOINTS, URDF, speed=speed)
