"""The torques of rigid bodies, by the laws they follow."""

import numpy as np
import pytest
from mechanism_examples import robot, tree_of

from lagrangian_ff.errors import ModelError
from lagrangian_ff.kernels import States
from lagrangian_ff.kernels.rigid import Robot, Tree

TREES = [((-1,), (0,)), ((-1, 0, 1), (0, 0, 1)), ((-1, 0, 0, 2), (1, 0, 0, 0))]


def rates(tree: Tree, q: np.ndarray, qdd: np.ndarray) -> np.ndarray:
    """(M, N) torque without velocity."""
    return tree.torque(States.of(q, np.zeros_like(q), qdd))


def mass_matrix(tree: Tree, q: np.ndarray) -> np.ndarray:
    """(M, N, N) by unit accelerations."""
    rest = rates(tree, q, np.zeros_like(q))
    columns = [rates(tree, q, np.broadcast_to(one, q.shape)) - rest for one in np.eye(q.shape[1])]
    return np.stack(columns, axis=2)


@pytest.mark.parametrize(("parent", "sliding"), TREES)
def test_the_mass_matrix_is_symmetric_and_positive(
    parent: tuple[int, ...], sliding: tuple[int, ...]
) -> None:
    q = np.random.default_rng(0).normal(size=(20, len(parent)))
    mass = mass_matrix(tree_of(parent, sliding, 1), q)
    np.testing.assert_allclose(mass, mass.transpose(0, 2, 1), atol=1e-12)
    assert np.linalg.eigvalsh(mass).min() > 0.0


@pytest.mark.parametrize(("parent", "sliding"), TREES)
def test_power_becomes_kinetic_energy_and_height(
    parent: tuple[int, ...], sliding: tuple[int, ...]
) -> None:
    tree, joints = tree_of(parent, sliding, 2), len(parent)
    t = np.linspace(0.0, 2.0, 4001)[:, None]
    speed = np.arange(1, joints + 1)
    q, qd, qdd = np.sin(speed * t), speed * np.cos(speed * t), -(speed**2) * np.sin(speed * t)
    rest = rates(tree, q, np.zeros_like(q))
    power = np.sum(qd * (tree.torque(States.of(q, qd, qdd)) - rest), axis=1)
    energy = 0.5 * np.einsum("mi,mij,mj->m", qd, mass_matrix(tree, q), qd)
    work = np.concatenate([[0.0], np.cumsum(0.5 * (power[1:] + power[:-1])) * (t[1, 0] - t[0, 0])])
    np.testing.assert_allclose(energy - energy[0], work, atol=2e-5 * energy.max())


@pytest.mark.parametrize(("parent", "sliding"), TREES)
def test_gravity_derives_from_a_potential(
    parent: tuple[int, ...], sliding: tuple[int, ...]
) -> None:
    tree, joints = tree_of(parent, sliding, 3), len(parent)
    q = np.random.default_rng(1).normal(size=(6, joints))
    step = 1e-5
    slope = np.empty((6, joints, joints))
    for n, one in enumerate(np.eye(joints)):
        up, down = (rates(tree, q + sign * step * one, 0.0 * q) for sign in (1.0, -1.0))
        slope[:, :, n] = (up - down) / (2.0 * step)
    np.testing.assert_allclose(slope, slope.transpose(0, 2, 1), atol=1e-7)


def test_a_lift_carries_weight_and_inertia() -> None:
    tree = tree_of((-1,), (1,), 4)
    lift = Tree(**{**vars(tree), "rotation": np.eye(3)[None], "axis": np.array([[0.0, 0.0, 1.0]])})
    x = States.of([[0.3], [0.1]], [[2.0], [1.0]], [[0.0], [1.5]])
    mass = tree.inertial[0, 0]
    np.testing.assert_allclose(lift.torque(x)[:, 0], [mass * 9.81, mass * (9.81 + 1.5)])


def test_joints_are_taken_in_the_order_of_the_recording() -> None:
    one = robot()
    x = States.of(*np.random.default_rng(2).normal(size=(3, 5, 3)))
    turned = one.of_joints(("c", "a", "b"), "test")
    swap = [2, 0, 1]
    moved = States.of(x.q[:, swap], x.qd[:, swap], x.qdd[:, swap])
    np.testing.assert_allclose(turned.tree.torque(moved), one.tree.torque(x)[:, swap])
    assert list(turned.prismatic) == [1.0, 0.0, 0.0]


def test_what_is_not_recorded_stands_still() -> None:
    one = robot()
    some = one.of_joints(("a", "b"), "test")
    assert some.still == ("c",)
    x = States.of(*np.random.default_rng(3).normal(size=(3, 5, 3)))
    still = States.of(*(np.where([True, True, False], part, 0.0) for part in (x.q, x.qd, x.qdd)))
    expected = one.tree.torque(still)[:, :2]
    found = some.tree.torque(States.of(x.q[:, :2], x.qd[:, :2], x.qdd[:, :2]))
    np.testing.assert_allclose(found, expected)


def test_a_joint_that_mimics_adds_its_power_to_that_of_its_leader() -> None:
    one = robot()
    coupled = Robot("three", one.tree, one.movable, {"c": ("b", -0.5, 0.1)})
    coupled = coupled.of_joints(("a", "b"), "test")
    assert coupled.still == ()
    x = States.of(*np.random.default_rng(4).normal(size=(3, 5, 2)))
    g = np.array([[1.0, 0.0], [0.0, 1.0], [0.0, -0.5]])
    whole = States.of(x.q @ g.T + [0.0, 0.0, 0.1], x.qd @ g.T, x.qdd @ g.T)
    np.testing.assert_allclose(coupled.tree.torque(x), one.tree.torque(whole) @ g)


def test_other_joints_are_refused_with_both_lists() -> None:
    with pytest.raises(ModelError, match=r"has no x, y; recorded: a, x, y; movable .*: a, b, c"):
        robot().of_joints(("a", "x", "y"), "bag")


def test_it_is_the_same_after_a_round_trip_as_json() -> None:
    import json

    one = robot().of_joints(("b", "a"), "test")
    again = Robot.from_stored(json.loads(json.dumps(one.stored())))
    x = States.of(*np.random.default_rng(5).normal(size=(3, 5, 2)))
    np.testing.assert_array_equal(again.tree.regressor(x), one.tree.regressor(x))
    assert (again.joints, again.movable, again.still) == (one.joints, one.movable, one.still)
    held = one.stored()
    tree = held["tree"]
    assert isinstance(tree, dict)
    for name, value, words in (
        ("axis", [[0.0, 0.0, 1.0]], "axis of the robot has shape"),
        ("shift", [np.nan, 0.0, 0.0], "shift of the robot holds values that are not finite"),
        ("parent", [-1, 0, 2], "hangs on one that does not come before it"),
        ("driver", [0, 1, 2], "moved by a joint that is not there"),
    ):
        with pytest.raises(ValueError, match=words):
            Robot.from_stored({**held, "tree": {**tree, name: value}})
