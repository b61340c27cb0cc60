"""Reading URDFs: what Pinocchio makes of them, and what is refused."""

import sys
from pathlib import Path

import numpy as np
import pytest
from mechanism_examples import pendulum_urdf

from lagrangian_ff.errors import ModelError
from lagrangian_ff.kernels import States
from lagrangian_ff.kernels.rigid import read_urdf, robot_of

pinocchio = pytest.importorskip("pinocchio", reason="Pinocchio, the extra urdf, is not installed")

ARM = Path(__file__).resolve().parents[3] / "lagrangian_ff" / "arm" / "arm6.urdf"
INERTIA = '<inertia ixx="0.02" ixy="0.001" ixz="0" iyy="0.03" iyz="0.002" izz="0.04"/>'
GRIPPER = f"""<robot name="odd">
  <link name="world"/>
  <link name="base"><inertial><mass value="9"/>{INERTIA}</inertial></link>
  <link name="mast">
    <inertial><origin xyz="0.1 0.2 0.3" rpy="0.1 0.2 0.3"/><mass value="2"/>{INERTIA}</inertial>
  </link>
  <link name="slide">
    <inertial><origin xyz="0 0.2 0.1"/><mass value="1"/>{INERTIA}</inertial>
  </link>
  <link name="finger"><inertial><mass value="0.3"/>{INERTIA}</inertial></link>
  <link name="tip"><inertial><mass value="0.1"/>{INERTIA}</inertial></link>
  <joint name="mount" type="fixed"><parent link="world"/><child link="base"/>
    <origin xyz="0 0 1" rpy="0.3 0.2 0.1"/></joint>
  <joint name="turn" type="continuous"><parent link="base"/><child link="mast"/>
    <origin xyz="0.1 0 0" rpy="0.4 0 0"/><axis xyz="0 1 1"/></joint>
  <joint name="reach" type="prismatic"><parent link="mast"/><child link="slide"/>
    <limit lower="0" upper="1" effort="9" velocity="1"/></joint>
  <joint name="grip" type="prismatic"><parent link="slide"/><child link="finger"/>
    <axis xyz="0 1 0"/><limit lower="0" upper="1" effort="9" velocity="1"/>
    <mimic joint="reach" multiplier="-0.5" offset="0.1"/></joint>
  <joint name="tip_mount" type="fixed"><parent link="finger"/><child link="tip"/>
    <origin xyz="0.3 0 0" rpy="0 1 0"/><axis xyz="0 0 0"/></joint>
</robot>
"""


@pytest.mark.parametrize("text", [ARM.read_text(), GRIPPER], ids=["arm", "gripper"])
def test_torques_are_those_of_pinocchio(text: str) -> None:
    robot = robot_of(text, "test")
    model = pinocchio.buildModelFromXML(text)
    data = model.createData()
    x = States.of(*np.random.default_rng(0).normal(size=(3, 10, model.nv)))
    found = robot.tree.torque(x)
    assert tuple(model.names)[1:] == robot.movable
    for n in range(10):
        # A continuous joint is a cosine and a sine to Pinocchio.
        q = [
            part
            for joint, value in zip(list(model.joints)[1:], x.q[n], strict=True)
            for part in ([np.cos(value), np.sin(value)] if joint.nq == 2 else [value])
        ]
        expected = pinocchio.rnea(model, data, np.array(q), x.qd[n], x.qdd[n])
        np.testing.assert_allclose(found[n], expected, atol=1e-12)


def test_joints_say_how_they_move() -> None:
    robot = robot_of(GRIPPER, "test").of_joints(("reach", "turn"), "test")
    assert list(robot.prismatic) == [1.0, 0.0]
    assert robot.still == ()
    x = States.of(*np.random.default_rng(1).normal(size=(3, 5, 2)))
    all_three = robot_of(GRIPPER, "test")
    g = np.array([[0.0, 1.0], [1.0, 0.0], [-0.5, 0.0]])  # turn, reach, grip
    whole = States.of(x.q @ g.T + [0.0, 0.0, 0.1], x.qd @ g.T, x.qdd @ g.T)
    np.testing.assert_allclose(robot.tree.torque(x), all_three.tree.torque(whole) @ g)


def test_an_axis_need_not_be_of_length_one() -> None:
    robot = robot_of(pendulum_urdf(), "test")
    np.testing.assert_allclose(robot.tree.axis, [[0.0, -1.0, 0.0], [0.0, -1.0, 0.0]])
    longer = robot_of(pendulum_urdf().replace("0 -2 0", "0 -1 0"), "test")
    x = States.of(*np.random.default_rng(2).normal(size=(3, 5, 2)))
    np.testing.assert_allclose(robot.tree.torque(x), longer.tree.torque(x))


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("", "is no URDF: it is not XML"),
        ("<robot><link>", r"is no URDF: it is not XML .*xacro"),
        ("<sdf/>", "its root is <sdf>, expected <robot>"),
        ("<robot name='r'><link name='a'/></robot>", "has no movable joint"),
        (GRIPPER.replace('"continuous"', '"planar"'), "joint turn is of the type planar, expected"),
        (GRIPPER.replace('"continuous"', '"screw"'), "joint turn is of the type screw, expected"),
        (GRIPPER.replace('"0 1 1"', '"0 0 0"'), "axis of joint turn is '0 0 0'"),
        (GRIPPER.replace('"0 1 1"', '"up"'), "axis of joint turn is 'up'"),
        (GRIPPER.replace('joint="reach"', 'joint="gone"'), "grip mimics gone, which is not"),
        (GRIPPER.replace('joint="reach"', 'joint="grip"'), "grip mimics joints that mimic each"),
        (GRIPPER.replace('"-0.5"', '"half"'), "how joint grip mimics reach"),
        (GRIPPER.replace('parent link="mast"', 'parent link="no"'), "Pinocchio cannot read"),
    ],
)
def test_what_is_no_urdf_is_told(text: str, expected: str, tmp_path: Path) -> None:
    (tmp_path / "bad.urdf").write_text(text)
    with pytest.raises(ModelError, match=expected) as caught:
        read_urdf(tmp_path / "bad.urdf")
    assert "bad.urdf" in str(caught.value)


def test_a_file_that_cannot_be_read_is_told(tmp_path: Path) -> None:
    with pytest.raises(ModelError, match="no URDF file"):
        read_urdf(tmp_path / "none.urdf")
    with pytest.raises(ModelError, match="is a folder, expected a file"):
        read_urdf(tmp_path)
    (tmp_path / "binary.urdf").write_bytes(b"\xff\xfe\x00robot")
    with pytest.raises(ModelError, match="it is not text"):
        read_urdf(tmp_path / "binary.urdf")


def test_without_pinocchio_the_extra_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "pinocchio", None)
    with pytest.raises(ModelError, match="extra 'urdf' of lagrangian_ff: pip install pin"):
        robot_of(pendulum_urdf(), "test.urdf")


def test_what_would_exhaust_a_reader_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "deep.urdf"
    path.write_text("<robot>" + "<a>" * 100_000)
    with pytest.raises(ModelError, match=r"deep\.urdf: <a> lies inside 100 others"):
        read_urdf(path)
    entities = "".join(f'<!ENTITY e{k} "{f"&e{k - 1};" * 9}">' for k in range(1, 12))
    path.write_text(f'<!DOCTYPE robot [<!ENTITY e0 "{"x" * 999}">{entities}]><robot>&e11;</robot>')
    with pytest.raises(ModelError, match=r"deep\.urdf is no URDF: it is not XML .*amplification"):
        read_urdf(path)
    joints = '<joint type="fixed"/>' * 1001
    path.write_text(f"<robot>{joints}</robot>")
    with pytest.raises(ModelError, match="more than 1000 joints"):
        read_urdf(path)
    (tmp_path / "zero.urdf").symlink_to("/dev/zero")
    with pytest.raises(ModelError, match="is a device, expected a file"):
        read_urdf(tmp_path / "zero.urdf")


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('<mass value="2"/>', '<mass value="1e308"/>', "the inertia of joint turn is not finite"),
        ('<axis xyz="0 1 1"/>', '<axis xyz="0 inf 1"/>', "the axis of joint turn"),
    ],
)
def test_numbers_that_are_not_finite_are_named(old: str, new: str, message: str) -> None:
    with pytest.raises(ModelError, match=message):
        robot_of(GRIPPER.replace(old, new), "odd.urdf")


def test_a_long_chain_of_mimic_joints_is_followed() -> None:
    names = [f"j{k}" for k in range(400)]
    joints = "".join(
        f'<link name="{name}"><inertial><mass value="1"/>{INERTIA}</inertial></link>'
        f'<joint name="{name}" type="continuous"><parent link="base"/><child link="{name}"/>'
        + (f'<mimic joint="j{k - 1}"/>' if k else "")
        + "</joint>"
        for k, name in enumerate(names)
    )
    robot = robot_of(f'<robot name="r"><link name="base"/>{joints}</robot>', "chain.urdf")
    assert (robot.of_joints(("j0",), "test").tree.driver == 0).all()


def test_a_line_break_in_the_name_of_a_joint_is_refused() -> None:
    with pytest.raises(ModelError, match=r"the joint 'tu\\nrn' holds a line break"):
        robot_of(GRIPPER.replace('name="turn"', 'name="tu\nrn"'), "odd.urdf")
