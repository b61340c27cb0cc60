"""Samples of random robots: bounded, in one unit, and the same whatever else is asked."""

import numpy as np

from lagrangian_ff.studies.robots.draw import draw_robot
from lagrangian_ff.studies.robots.samples import REACH, Scene, draw_samples

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
    np.testing.assert_array_equal(clean.ideal, rough.ideal)
    noise = rough.tau - clean.tau - rough.friction
    assert 0.045 < noise.std() < 0.055
    robot = draw_robot(0, 2, 1)
    lost = robot.viscous * rough.asked.qd + robot.coulomb * np.sign(rough.asked.qd)
    np.testing.assert_allclose((rough.truth - clean.truth) * rough.unit, lost)
    assert np.all(clean.friction == 0.0)
