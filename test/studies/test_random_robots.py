"""Random robots: the torques of rigid bodies, and samples that depend on nothing else."""

import numpy as np
import pinocchio
import pytest

from lagrangian_ff.kernels import States
from lagrangian_ff.studies.robots import GRAVITY, REACH, Robot, Scene, draw_robot, draw_samples


def some_states(joints: int, count: int = 20) -> States:
    random = np.random.default_rng(joints)
    return States.of(*(random.uniform(-3.0, 3.0, (count, joints)) for _ in range(3)))


def in_pinocchio(robot: Robot) -> pinocchio.Model:
    model = pinocchio.Model()
    model.gravity.linear = np.array([0.0, 0.0, -GRAVITY])
    parent = 0
    for n in range(robot.joints):
        place = pinocchio.SE3(robot.rotation[n], robot.offset[n])
        parent = model.addJoint(parent, pinocchio.JointModelRZ(), place, f"joint_{n}")
        body = pinocchio.Inertia(robot.mass[n], robot.centre[n], robot.inertia[n])
        model.appendBodyToJoint(parent, body, pinocchio.SE3.Identity())
    return model


@pytest.mark.parametrize("joints", [1, 2, 5, 8])
def test_torques_are_those_of_pinocchio(joints: int) -> None:
    robot, x = draw_robot(0, joints, 3), some_states(joints)
    model = in_pinocchio(robot)
    data = model.createData()
    states = zip(x.q, x.qd, x.qdd, strict=True)
    bodies = np.array([pinocchio.rnea(model, data, *state) for state in states])
    # Pinocchio 2 leaves rotors out of rnea.
    np.testing.assert_allclose(
        robot.torque(x), bodies + robot.rotor * x.qdd, rtol=1e-11, atol=1e-10
    )


def test_a_closed_motion_takes_no_work() -> None:
    # The trapezoid rule is exact to rounding for smooth periodic functions.
    robot, random = draw_robot(1, 4, 0), np.random.default_rng(0)
    time = 2.0 * np.pi * np.arange(400) / 400
    harmonic = np.array([1, 2, 3])[:, None]
    cosine, sine = np.cos(harmonic * time), np.sin(harmonic * time)
    a, b = random.normal(size=(2, 4, 3)) / 3.0
    q = a @ cosine + b @ sine
    qd = (b * harmonic.T) @ cosine - (a * harmonic.T) @ sine
    qdd = -(a * harmonic.T**2) @ cosine - (b * harmonic.T**2) @ sine
    x = States.of(q.T, qd.T, qdd.T)
    power = np.sum(robot.torque(x) * x.qd, axis=1)
    assert np.abs(power).mean() > 1.0
    assert abs(power.mean()) < 1e-10 * np.abs(power).mean()
    lost = np.sum(robot.friction(x) * x.qd, axis=1)
    assert lost.min() > 0.0


@pytest.mark.parametrize("number", range(5))
def test_the_mass_matrix_is_that_of_matter(number: int) -> None:
    robot = draw_robot(2, 6, number)
    q = some_states(6).q
    still = np.zeros_like(q)
    at_rest = robot.torque(States.of(q, still, still))
    moved = [robot.torque(States.of(q, still, still + one)) - at_rest for one in np.eye(6)]
    matrix = np.stack(moved, axis=-1)
    np.testing.assert_allclose(matrix, matrix.swapaxes(1, 2), atol=1e-10)
    # A rotor turns with its joint whatever the links do.
    assert np.all(np.linalg.eigvalsh(matrix)[:, 0] >= robot.rotor.min())
    principal = np.linalg.eigvalsh(robot.inertia)
    assert np.all(principal[:, 0] > 0.0)
    assert np.all(principal[:, 0] + principal[:, 1] >= principal[:, 2])
    assert np.all(robot.viscous >= 0.0)
    assert np.all(robot.coulomb >= 0.0)


def test_every_seed_size_and_number_is_another_robot_and_always_the_same() -> None:
    places = [(seed, joints, number) for seed in (0, 1) for joints in (1, 2) for number in (0, 7)]
    masses = [float(draw_robot(*place).mass[0]) for place in places]
    assert len(set(masses)) == len(places)
    assert masses == [float(draw_robot(*place).mass[0]) for place in places]


SMALL = Scene(training=200, validation=300)
ROUGH = Scene(training=200, validation=300, friction=True, noise=0.05)


def test_states_fill_their_bounds_and_the_largest_torque_is_one() -> None:
    samples = draw_samples(SMALL, 0, 3, 0)
    for values, reach in zip((samples.x.q, samples.x.qd, samples.x.qdd), REACH, strict=True):
        assert 0.95 * reach < np.abs(values).max() <= reach
    assert np.abs(samples.tau).max() == 1.0
    robot = draw_robot(0, 3, 0)
    np.testing.assert_allclose(samples.tau * samples.unit, robot.torque(samples.x))
    np.testing.assert_allclose(samples.truth * samples.unit, robot.torque(samples.asked))


def test_folds_are_as_large_as_each_other_and_in_no_order() -> None:
    fold = draw_samples(SMALL, 0, 2, 0).fold
    assert np.all(np.bincount(fold) == 40)
    assert np.all(np.bincount(fold[:100], minlength=5) > 10)
    assert not np.array_equal(fold, np.arange(200) % 5)


def test_friction_and_noise_leave_the_rest_as_it_was() -> None:
    clean, rough = draw_samples(SMALL, 0, 2, 1), draw_samples(ROUGH, 0, 2, 1)
    np.testing.assert_array_equal(clean.x.q, rough.x.q)
    np.testing.assert_array_equal(clean.unit, rough.unit)
    noise = rough.tau - clean.tau - rough.friction
    assert 0.045 < noise.std() < 0.055
    robot = draw_robot(0, 2, 1)
    lost = robot.viscous * rough.asked.qd + robot.coulomb * np.sign(rough.asked.qd)
    np.testing.assert_allclose((rough.truth - clean.truth) * rough.unit, lost)
    assert np.all(clean.friction == 0.0)
