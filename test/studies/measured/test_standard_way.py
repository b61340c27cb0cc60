"""The standard way is exact where its assumptions hold; its kinematics are those of the table."""

import numpy as np
import pinocchio
import pytest
from measured_examples import JOINTS, PENDULUM, states, torques

from lagrangian_ff.arrays import Floats
from lagrangian_ff.errors import ModelError
from lagrangian_ff.kernels.states import States
from lagrangian_ff.recording.motion import Motion
from lagrangian_ff.studies.measured.kinematics import MODIFIED, STANDARD, Kinematics, Row
from lagrangian_ff.studies.measured.standard import StandardWay


def motion(seed: int, order: tuple[int, ...] = (0, 1)) -> Motion:
    time, *held = states(6.0, seed=seed)
    q, qd, qdd, tau = (values[:, order] for values in (*held, torques(*held)))
    names = tuple(JOINTS[k] for k in order)
    return Motion(names, time, q, qd, qdd, tau, np.zeros(len(time), dtype=np.int64))


@pytest.mark.parametrize("kind", ["revolute", "continuous"])
@pytest.mark.parametrize("order", [(0, 1), (1, 0)])
def test_rigid_bodies_with_friction_are_learned_exactly(order: tuple[int, ...], kind: str) -> None:
    urdf = PENDULUM.text(JOINTS).replace("revolute", kind)
    found = StandardWay.identified(urdf, PENDULUM.gravity, motion(0, order), "pendulum")
    unseen = motion(1, order)
    np.testing.assert_allclose(found.predict(unseen), unseen.tau, atol=1e-8)


def test_more_joints_than_the_motion_has_stand_still() -> None:
    alone = motion(0).select(["shoulder"])
    found = StandardWay.identified(PENDULUM.text(JOINTS), PENDULUM.gravity, alone, "pendulum")
    assert found.predict(alone).shape == alone.tau.shape


def test_a_motion_of_other_joints_is_refused() -> None:
    with pytest.raises(ModelError, match="no joint shoulder, elbow; it has a, b"):
        StandardWay.identified(PENDULUM.text(("a", "b")), PENDULUM.gravity, motion(0), "it")


def turned(row: Row, angle: float, convention: str) -> Floats:
    """Return the transform of a row as textbooks write it."""
    ca, sa = np.cos(row.alpha), np.sin(row.alpha)
    ct, st = np.cos(angle + row.theta), np.sin(angle + row.theta)
    if convention == STANDARD:
        rows = [
            [ct, -st * ca, st * sa, row.a * ct],
            [st, ct * ca, -ct * sa, row.a * st],
            [0, sa, ca, row.d],
        ]
    else:
        rows = [
            [ct, -st, 0, row.a],
            [st * ca, ct * ca, -sa, -row.d * sa],
            [st * sa, ct * sa, ca, row.d * ca],
        ]
    return np.array([*rows, [0, 0, 0, 1]])


@pytest.mark.parametrize("convention", [STANDARD, MODIFIED])
def test_the_urdf_stands_as_the_table(convention: str) -> None:
    random = np.random.default_rng(3)
    turns = np.array([0.5, -0.5, 0.0, 1.0]) * np.pi
    lengths = random.uniform(-1, 1, (4, 3))
    rows = tuple(Row(a, d, turns[k], theta, 1.0) for k, (a, d, theta) in enumerate(lengths))
    names = tuple("abcd")
    text = Kinematics("made up", None, convention, rows).text(names)
    body = pinocchio.buildModelFromXML(text)
    data, angles = body.createData(), random.uniform(-2, 2, 4)
    pinocchio.forwardKinematics(body, data, angles)
    place = np.eye(4)
    for k, (row, angle) in enumerate(zip(rows, angles, strict=True)):
        place = place @ turned(row, angle, convention)
        found = data.oMi[k + 1]
        # A joint's frame is that of its row, but for what a standard row has behind its joint.
        behind = (
            np.eye(4) if convention == MODIFIED else turned(Row(row.a, 0, row.alpha), 0, STANDARD)
        )
        np.testing.assert_allclose(found.homogeneous @ behind, place, atol=1e-9)


def test_the_robot_for_identify_has_the_torque_of_the_urdf() -> None:
    _, q, qd, qdd = states(1.0)
    friction = torques(q, qd, qdd)[:1] * 0.0
    robot = PENDULUM.robot(JOINTS)
    body = pinocchio.buildModelFromXML(PENDULUM.text(JOINTS))
    body.gravity.linear = np.array(PENDULUM.gravity)
    expected = pinocchio.rnea(body, body.createData(), q[7], qd[7], qdd[7]) + friction[0]
    found = robot.tree.torque(States.of(q[7:8], qd[7:8], qdd[7:8]))
    np.testing.assert_allclose(found[0], expected, atol=1e-9)
